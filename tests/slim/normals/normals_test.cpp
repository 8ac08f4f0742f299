#include "slim/normals/estimate.h"
#include "slim/normals/orient.h"
#include "slim/normals/pair_weights.h"
#include "slim/normals/repair.h"
#include "slim/normals/sign_merge.h"

#include "slim/base/frame.h"
#include "slim/base/parallel.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

std::vector<std::uint32_t> all_of(const PointBlock& block) {
    std::vector<std::uint32_t> ids(block.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

NeighborGraph estimate(PointBlock& block, const std::vector<std::uint32_t>& wanted, std::size_t k,
                       std::size_t& degenerate) {
    return estimate_normals(block, NearestSearch(block.position), wanted, k, degenerate);
}

NormalAudit repair(PointBlock& block) {
    return repair_contrary_normals(
        block, BoxTree(block.size(), [&](std::size_t i) { return block.position[i]; }));
}

/// The block with normals estimated anew, and oriented by its neighbours alone.
OrientReport estimate_and_orient(PointBlock& block, std::size_t k = 16) {
    std::size_t degenerate = 0;
    const NeighborGraph graph = estimate(block, all_of(block), k, degenerate);
    EXPECT_EQ(degenerate, 0u);
    std::vector<bool> known(block.size(), false);
    return orient_by_neighbors(block, graph, known);
}

double share_agreeing(const PointBlock& block, const std::vector<Vec3f>& truth) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < block.size(); ++i) n += dot(block.normal[i], truth[i]) > 0;
    return static_cast<double>(n) / static_cast<double>(block.size());
}

TEST(EstimateNormals, IsWithinADegreeOnASphere) {
    const Cloud cloud = sampled("sphere", 20000);
    PointBlock block = along_curve(block_of(cloud));
    std::size_t degenerate = 7;
    estimate(block, all_of(block), 16, degenerate);
    EXPECT_EQ(degenerate, 0u);
    double sq_sum = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        ASSERT_NEAR(length(block.normal[i]), 1, 1e-6);
        const double sine =
            length(cross(to_double(block.normal[i]), cloud.truth[block.id[i]].normal));
        sq_sum += sine * sine;
    }
    const double rms_deg = std::sqrt(sq_sum / 20000) * 180 / std::numbers::pi;
    EXPECT_LT(rms_deg, 1);
}

TEST(EstimateNormals, CountsNeighboursThatSpanNoPlane) {
    std::vector<Vec3d> line;
    for (int i = 0; i < 100; ++i) line.push_back({0.01 * i, 0, 0});
    PointBlock block = along_curve(block_of(line, std::vector<Vec3f>(line.size())));
    std::size_t degenerate = 0;
    estimate(block, all_of(block), 8, degenerate);
    EXPECT_EQ(degenerate, 100u);
    for (const Vec3f& n : block.normal) {
        EXPECT_NEAR(length(n), 1, 1e-6);
        EXPECT_NEAR(n.x, 0, 1e-3);  // any direction, but across the line
    }
}

TEST(EstimateNormals, DuplicatesGiveTheNormalsOfTheUniqueSet) {
    const Cloud cloud = sampled("torus", 3000);
    Cloud copies;
    for (int c = 0; c < 12; ++c)
        copies.positions.insert(copies.positions.end(), cloud.positions.begin(),
                                cloud.positions.end());
    PointBlock once = along_curve(block_of(cloud));
    PointBlock twelve =
        along_curve(block_of(copies.positions, std::vector<Vec3f>(copies.positions.size())));
    std::size_t degenerate = 0;
    estimate(once, all_of(once), 16, degenerate);
    estimate(twelve, all_of(twelve), 16, degenerate);
    std::vector<Vec3f> normals(cloud.size());
    for (std::size_t i = 0; i < once.size(); ++i) normals[once.id[i]] = once.normal[i];
    for (std::size_t i = 0; i < twelve.size(); ++i)
        ASSERT_GT(std::abs(dot(twelve.normal[i], normals[twelve.id[i] % cloud.size()])), 0.99999f);
}

TEST(EstimateNormals, TouchesTheWantedOnly) {
    PointBlock block = along_curve(block_of(sampled("sphere", 2000)));
    const std::vector<Vec3f> before = block.normal;
    const std::vector<std::uint32_t> wanted{3, 500, 1999};
    block.normal[3] = block.normal[500] = block.normal[1999] = {};
    std::size_t degenerate = 0;
    EXPECT_EQ(estimate(block, wanted, 16, degenerate).points, wanted);
    for (std::size_t i = 0; i < block.size(); ++i) {
        const bool is_wanted = i == 3 || i == 500 || i == 1999;
        if (is_wanted) {
            EXPECT_GT(std::abs(dot(block.normal[i], before[i])), 0.99f);
        } else {
            ASSERT_EQ(block.normal[i], before[i]);
        }
    }
}

TEST(NeighborGraph, IsCutToTheCloud) {
    PointBlock block = along_curve(block_of(sampled("sphere", 5)));
    std::size_t degenerate = 0;
    EXPECT_EQ(estimate(block, all_of(block), 16, degenerate).k, 5u);
}

TEST(Orient, ClosedShapesFaceOutwards) {
    for (const char* shape : {"sphere", "torus", "ellipsoid", "bumpy"}) {
        SCOPED_TRACE(shape);
        PointBlock block = along_curve(block_of(sampled(shape, 20000)));
        const std::vector<Vec3f> truth = block.normal;
        const OrientReport report = estimate_and_orient(block);
        EXPECT_EQ(share_agreeing(block, truth), 1);
        EXPECT_EQ(report.components, 1u);
        EXPECT_EQ(report.by_rule, block.size());
    }
}

/// A box of 1 by 1 by `height`, points at random by area.
PointBlock box_points(std::size_t n, double height) {
    PointBlock block;
    const double sides = 4 * height;
    for (std::size_t i = 0; i < n; ++i) {
        const auto unit = [&](std::uint64_t k) { return unit_interval(keyed_hash(k, i)); };
        const double u = unit(1), v = unit(2), which = unit(3) * (2 + sides);
        Vec3d p{u, v, which < 1 ? 0 : height}, n_out{0, 0, which < 1 ? -1.0 : 1.0};
        if (which > 2) {
            const int side = std::min(3, static_cast<int>((which - 2) / height));
            const double at = side % 2;
            p = side < 2 ? Vec3d{at, u, v * height} : Vec3d{u, at, v * height};
            n_out = side < 2 ? Vec3d{2 * at - 1, 0, 0} : Vec3d{0, 2 * at - 1, 0};
        }
        block.position.push_back(p);
        block.normal.push_back(to_float(n_out));
        block.id.push_back(i);
    }
    return block;
}

// A plate four spacings thick, of 16 neighbours: a spanning tree that joins the nearest to parallel
// first goes over the rim by a pair that says the wrong thing, and half of the plate faces inwards.
TEST(Orient, ManyVotesCarryTheSignRoundAThinRim) {
    for (const double height : {0.06, 0.1, 1.0}) {
        SCOPED_TRACE(height);
        PointBlock block = along_curve(box_points(4000, height));
        const std::vector<Vec3f> truth = block.normal;
        estimate_and_orient(block);
        EXPECT_GT(share_agreeing(block, truth), 0.99);
    }
}

TEST(SignMerge, AWrongVoteIsOutvotedWhereASpanningTreeFollowsIt) {
    // 0 and 1 are surely alike, 2 and 3 too; a single sure vote says that 1 and 2 are opposite, three
    // weaker ones between the two pairs that they are alike.
    const std::vector<SignVote> votes{{0, 1, 5}, {2, 3, 5}, {1, 2, -2}, {0, 2, 1}, {0, 3, 1}, {1, 3, 1}};
    SignedForest forest = merge_by_votes(5, votes);
    for (std::uint32_t i = 1; i < 4; ++i) {
        EXPECT_EQ(forest.find(i).index, forest.find(0).index);
        EXPECT_EQ(forest.find(i).flipped, forest.find(0).flipped);
    }
    EXPECT_NE(forest.find(4).index, forest.find(0).index);  // nobody votes on it
}

TEST(PairWeights, FindsWhatAMapFindsAfterManyErasures) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> truth;
    PairWeights weights(64);
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const auto number = [&](std::uint64_t k) {
            return static_cast<std::uint32_t>(keyed_hash(k, i) % 24);
        };
        const auto [a, b] = std::minmax(number(1), number(2));
        if (a == b) continue;
        const auto known = truth.find({a, b});
        const std::size_t at = weights.find(b, a);
        ASSERT_EQ(at != PairWeights::kNone, known != truth.end());
        if (at != PairWeights::kNone) {
            ASSERT_EQ(weights.weight(at), known->second);
        }
        if (known != truth.end() && number(3) % 2) {
            weights.erase(at);
            truth.erase(known);
        } else if (known != truth.end() || truth.size() < 64) {
            weights.add(a, b, static_cast<double>(i));
            truth[{a, b}] += static_cast<double>(i);
        }
    }
    std::size_t n = 0;
    weights.for_each([&](std::uint32_t a, std::uint32_t b, double weight) {
        EXPECT_EQ(weight, truth.at({a, b}));
        ++n;
    });
    EXPECT_EQ(n, truth.size());
}

TEST(SignMerge, OppositeGroupsHandOnWhatTheySayOfOthers) {
    const std::vector<SignVote> votes{{0, 1, -3}, {1, 2, 1}, {0, 2, 0.5}};
    SignedForest forest = merge_by_votes(3, votes);
    EXPECT_NE(forest.find(1).flipped, forest.find(0).flipped);
    EXPECT_NE(forest.find(2).flipped, forest.find(0).flipped);  // as 1, by 1 against 0.5
}

TEST(Orient, ATerrainFacesUp) {
    PointBlock block = along_curve(graph_points(10000, 1, 5, [](double u, double v) {
        return 0.1 * std::sin(4 * u) * std::cos(3 * v);
    }));
    estimate_and_orient(block);
    for (const Vec3f& n : block.normal) ASSERT_GT(n.z, 0);
}

TEST(Orient, SeparateShapesEachFaceOutwards) {
    PointBlock block = along_curve(block_of(sampled("sphere", 5000)));
    const PointBlock other = block_of(sampled("sphere", 5000, 2));
    for (std::size_t i = 0; i < other.size(); ++i) {
        block.position.push_back(other.position[i] + Vec3d{10, 0, 0});
        block.normal.push_back(other.normal[i]);
        block.id.push_back(block.id.size());
    }
    block = along_curve(block);
    const std::vector<Vec3f> truth = block.normal;
    const OrientReport report = estimate_and_orient(block);
    EXPECT_EQ(report.components, 2u);
    EXPECT_EQ(share_agreeing(block, truth), 1);
}

TEST(Orient, KnownSignsSpreadOverTheirComponent) {
    PointBlock block = along_curve(block_of(sampled("torus", 10000)));
    const std::vector<Vec3f> truth = block.normal;
    std::size_t degenerate = 0;
    const NeighborGraph graph = estimate(block, all_of(block), 16, degenerate);
    std::vector<bool> known(block.size(), false);
    for (std::size_t i = 0; i < 3; ++i) known[i] = true, block.normal[i] = -truth[i];
    const OrientReport report = orient_by_neighbors(block, graph, known);
    EXPECT_EQ(share_agreeing(block, truth), 0);  // all inwards, as the three say
    EXPECT_EQ(report.by_neighbors, block.size() - 3);
    EXPECT_EQ(report.by_rule, 0u);
    EXPECT_EQ(report.components, 0u);
}

TEST(Orient, TowardsTheSensorOfTheScan) {
    PointBlock block = along_curve(block_of(sampled("sphere", 4000)));
    const std::vector<Vec3f> truth = block.normal;
    // Two scanners, one within the sphere: its points shall face inwards. A third scan has no
    // sensor.
    for (std::size_t i = 0; i < block.size(); ++i) {
        block.scan.push_back(i % 5 == 0 ? 2 : block.position[i].x > 0 ? 0 : 1);
        if (i % 2) block.normal[i] = -block.normal[i];
    }
    const std::vector<Vec3f> mixed = block.normal;
    const std::vector<Vec3d> sensors{{100, 0, 0}, {0, 0, 0}};
    EXPECT_EQ(orient_to_sensors(block, all_of(block), sensors), 3200u);
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (block.scan[i] == 2) {
            ASSERT_EQ(block.normal[i], mixed[i]);
            continue;
        }
        const Vec3d view = sensors[block.scan[i]] - block.position[i];
        ASSERT_GE(dot(to_double(block.normal[i]), view), 0);
    }
    const std::vector<Vec3d> unknown{{NAN, NAN, NAN}};
    EXPECT_EQ(orient_to_sensors(block, all_of(block), unknown), 0u);
}

TEST(Orient, GivesTheSameForAnyNumberOfThreads) {
    std::vector<std::vector<Vec3f>> normals;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        PointBlock block = along_curve(block_of(sampled("sculpture", 10000, 1, 1e-3)));
        estimate_and_orient(block);
        normals.push_back(block.normal);
    }
    EXPECT_EQ(normals[0], normals[1]);
    EXPECT_EQ(normals[0], normals[2]);
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
        Vec3d sum{};
        double n = 0;
        for (std::size_t k = 0; k < block.size(); ++k) {
            if (k == i || length(block.position[k] - block.position[i]) >= radius) continue;
            sum += to_double(block.normal[k]);
            ++n;
        }
        if (n < 5) continue;
        const double agreement = length(sum) / n;
        const double cosine = dot(to_double(block.normal[i]), sum) / length(sum);
        audit.contrary += agreement >= 0.5 && cosine <= -0.3;
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
    // By chance one side is a clear majority of some 16 neighbours now and then.
    EXPECT_LT(audit.contrary, 600u);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sheet.size(); ++i) kept += sheet.normal[i] == normals[sheet.id[i]];
    EXPECT_EQ(kept + audit.contrary, sheet.size());
    EXPECT_GT(audit.opposed, 0.4 * audit.compared);
    EXPECT_FALSE(audit.has_mixed_signs());  // one side lies behind the other
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
