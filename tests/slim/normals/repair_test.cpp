#include "slim/normals/repair.h"

#include "slim/base/frame.h"
#include "tests/slim/fit/fit_support.h"
#include "tests/slim/normals/normals_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

NormalAudit repair(PointBlock& block) {
    return repair_contrary_normals(
        block, BoxTree(block.size(), [&](std::size_t i) { return block.position[i]; }));
}

TEST(Repair, TurnsSparseFlippedNormalsBack) {
    PointBlock block = along_curve(block_of(sampled("sphere", 20000)));
    const std::vector<Vec3f> truth = block.normal;
    std::size_t flipped = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (unit_interval(keyed_hash(5, i)) >= 0.05) continue;
        block.normal[i] = -block.normal[i];
        ++flipped;
    }
    const NormalAudit audit = repair(block);
    EXPECT_EQ(audit.n, block.size());
    EXPECT_EQ(audit.missing, 0u);
    // A few have too few neighbours or a neighbourhood full of flips.
    EXPECT_GT(static_cast<double>(audit.contrary), 0.97 * static_cast<double>(flipped));
    EXPECT_LE(audit.contrary, flipped);
    EXPECT_GT(share_agreeing(block, truth), 0.998);
    for (std::size_t i = 0; i < block.size(); ++i)  // what was right is not touched
        if (unit_interval(keyed_hash(5, i)) >= 0.05) {
            ASSERT_EQ(block.normal[i], truth[i]);
        }
}

/// Counts of an audit by its definition: all pairs.
NormalAudit audit_by_all_pairs(const PointBlock& block) {
    const BoxTree boxes(block.size(), [&](std::size_t i) { return block.position[i]; });
    std::vector<double> diagonals;
    for (std::size_t b = 0; b < boxes.n_buckets(); ++b)
        diagonals.push_back(boxes.bucket(b).diagonal());
    std::vector<double> sorted = diagonals;
    std::sort(sorted.begin(), sorted.end());
    NormalAudit audit;
    for (std::size_t i = 0; i < block.size(); ++i) {
        const double radius =
            std::min(0.5 * diagonals[i / BoxTree::kBucket], sorted[sorted.size() / 2]);
        const Vec3d own = to_double(block.normal[i]);
        Vec3d sum{};
        double n = 0, votes = 0, sizes = 0;
        for (std::size_t k = 0; k < block.size(); ++k) {
            const Vec3d d = block.position[k] - block.position[i], m = to_double(block.normal[k]);
            if (k == i || length(d) >= radius) continue;
            sum += m;
            ++n;
            const double vote = dot(m, own) - dot(m, d) * dot(own, d) / sq_length(d);
            const double weight = std::abs(vote) / (sq_length(d) / (radius * radius) + 0.03);
            votes += weight * vote;
            sizes += std::abs(weight * vote);
        }
        if (n < 5) continue;
        const double agreement = length(sum) / n;
        const double cosine = dot(to_double(block.normal[i]), sum) / length(sum);
        audit.contrary += agreement >= 0.5 && cosine <= -0.3 && votes <= -0.1 * sizes;
        audit.noisy += agreement > 0.7 && cosine < 0.3 && cosine > -0.3;
    }
    return audit;
}

TEST(Repair, FindsWhatAllPairsShow) {
    // Two spheres of other density, so that the curve jumps and buckets straddle; a third of the
    // normals is tilted at random.
    PointBlock block = block_of(sampled("sphere", 2500));
    const PointBlock far = block_of(sampled("sphere", 600));
    for (std::size_t i = 0; i < far.size(); ++i) {
        block.position.push_back(0.3 * far.position[i] + Vec3d{1.1, 0.2, -0.4});
        block.normal.push_back(far.normal[i]);
        block.id.push_back(block.id.size());
    }
    block = along_curve(std::move(block));
    for (std::size_t i = 0; i < block.size(); i += 3) {
        const Vec3d tilt{random_at(7, 3 * i), random_at(7, 3 * i + 1), random_at(7, 3 * i + 2)};
        block.normal[i] = normalized(to_float(to_double(block.normal[i]) + 2.5 * tilt));
    }
    const NormalAudit truth = audit_by_all_pairs(block), found = repair(block);
    EXPECT_GT(truth.contrary, 50u);
    EXPECT_GT(truth.noisy, 50u);
    EXPECT_EQ(found.contrary, truth.contrary);
    EXPECT_EQ(found.noisy, truth.noisy);
}

TEST(Repair, LeavesCleanNormalsAndAThinSheetAlone) {
    PointBlock clean = along_curve(block_of(sampled("sculpture", 20000)));
    const std::vector<Vec3f> before = clean.normal;
    EXPECT_LT(repair(clean).contrary, 10u);
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < 20000; ++i) {
        const bool top = unit_interval(keyed_hash(9, i)) < 0.5;
        positions.push_back({random_at(1, 2 * i), random_at(1, 2 * i + 1), top ? 0.001 : -0.001});
        normals.push_back({0, 0, top ? 1.0f : -1.0f});
    }
    PointBlock sheet = along_curve(block_of(positions, normals));
    const NormalAudit audit = repair(sheet);
    // By chance one side is a clear majority of some 16 neighbours now and then, and the nearest
    // ones.
    EXPECT_LT(audit.contrary, 100u);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sheet.size(); ++i) kept += sheet.normal[i] == normals[sheet.id[i]];
    EXPECT_EQ(kept + audit.contrary, sheet.size());
    EXPECT_GT(audit.opposed, 0.4 * audit.compared);
    EXPECT_FALSE(audit.has_mixed_signs());  // one side lies behind the other
}

TEST(Repair, LeavesANarrowRidgeInACreaseAlone) {
    // A row of points that faces a wall: the wall's are a majority against each of them, but lie
    // across, not beside.
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const auto at = [](std::size_t i, std::size_t k) {
        return (static_cast<double>(i) + 0.2 * random_at(3, k)) / 90;
    };
    for (std::size_t i = 0; i < 90 * 90; ++i)
        positions.push_back({at(i % 90, 2 * i), at(i / 90, 2 * i + 1), 0.02}),
            normals.push_back({0, 0, -1});
    for (std::size_t i = 0; i < 180; ++i)
        positions.push_back({0.5, 0.5 * at(i, 20000 + i), 0}), normals.push_back({0, 0, 1});
    PointBlock crease = along_curve(block_of(positions, normals));
    EXPECT_EQ(repair(crease).contrary, 0u);
    // Beside its own kind an opposed one is turned as ever.
    std::size_t flipped = 0;
    for (std::size_t i = 0; i < crease.size(); i += 97)
        if (crease.normal[i].z < 0) crease.normal[i] = -crease.normal[i], ++flipped;
    EXPECT_NEAR(static_cast<double>(repair(crease).contrary), static_cast<double>(flipped),
                2);  // but at the rims
}

TEST(Repair, SeesMixedSignsWhereNoMajorityIsLeft) {
    for (const double share : {0.0, 0.05, 0.2, 0.3, 0.5}) {
        PointBlock block = along_curve(block_of(sampled("sphere", 20000)));
        for (std::size_t i = 0; i < block.size(); ++i)
            if (unit_interval(keyed_hash(5, i)) < share) block.normal[i] = -block.normal[i];
        EXPECT_EQ(repair(block).has_mixed_signs(), share > 0.1) << share;
    }
}

TEST(Repair, CountsMissingAndNoisyNormals) {
    PointBlock block = along_curve(block_of(sampled("sphere", 20000)));
    for (std::size_t i = 0; i < 50; ++i) block.normal[i] = {};
    std::size_t tilted = 0;
    for (std::size_t i = 100; i < block.size(); i += 100, ++tilted) {
        // 90 degrees off: neither with nor against its neighbours.
        const Vec3d n = to_double(block.normal[i]);
        block.normal[i] = to_float(frame_from_normal(n).u_axis);
    }
    const NormalAudit audit = repair(block);
    EXPECT_EQ(audit.missing, 50u);
    EXPECT_EQ(audit.contrary, 0u);
    EXPECT_NEAR(static_cast<double>(audit.noisy), static_cast<double>(tilted),
                0.1 * static_cast<double>(tilted));
    for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(block.normal[i], (Vec3f{}));
}

}  // namespace
}  // namespace slim::test
