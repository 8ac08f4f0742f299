#include "slim/normals/evidence.h"

#include "tests/slim/fit/fit_support.h"
#include "tests/slim/normals/normals_support.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace slim::test {
namespace {

NormalEvidence evidence_of_all(const PointBlock& block) {
    std::vector<std::uint32_t> all(block.size());
    std::iota(all.begin(), all.end(), 0u);
    return evidence_of(block, NearestSearch(block.position), all);
}

PointBlock sphere_at(const Vec3d& center, std::size_t n, bool inwards) {
    PointBlock block = along_curve(block_of(sampled("sphere", n)));
    for (std::size_t i = 0; i < block.size(); ++i) {
        block.position[i] = block.position[i] + center;
        if (inwards) block.normal[i] = -block.normal[i];
    }
    return block;
}

TEST(NormalEvidence, InwardNormalsOfAClosedSurfaceAreToldWhereverItLies) {
    for (const Vec3d center : {Vec3d{}, Vec3d{30, -20, 5}}) {
        EXPECT_TRUE(evidence_of_all(sphere_at(center, 4000, true)).is_inward());
        NormalEvidence right = evidence_of_all(sphere_at(center, 4000, false));
        EXPECT_FALSE(right.is_inward());
        EXPECT_FALSE(right.is_off_surface());
        right.flip();
        EXPECT_TRUE(right.is_inward());
    }
}

TEST(NormalEvidence, OneStrayFarOffOutweighsNothing) {
    PointBlock block = sphere_at({}, 4000, true);
    block.position.push_back({900, 0, 0});
    block.normal.push_back({0, 1, 0});
    block.id.push_back(block.id.size());
    EXPECT_TRUE(evidence_of_all(block).is_inward());
}

TEST(NormalEvidence, SamplesOfSlicesOfUnlikeSizeAddUp) {
    // Halves of one closed surface, one of ten times the points, as many samples of each.
    const PointBlock all = sphere_at({}, 40000, true);
    NormalEvidence sum;
    for (const bool upper : {false, true}) {
        PointBlock half;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if ((all.position[i].z > 0) != upper || (upper && i % 10 != 0)) continue;
            half.position.push_back(all.position[i]);
            half.normal.push_back(all.normal[i]);
            half.id.push_back(all.id[i]);
        }
        std::vector<std::uint32_t> samples;
        for (std::size_t i = 0; i < half.size(); i += half.size() / 1000)
            samples.push_back(static_cast<std::uint32_t>(i));
        NormalEvidence one = evidence_of(half, NearestSearch(half.position), samples);
        const NormalEvidence as_sampled = one;
        one.stand_for(half.size());
        EXPECT_NEAR(one.area / as_sampled.area,
                    static_cast<double>(half.size()) / static_cast<double>(as_sampled.n), 1e-9);
        sum += one;
    }
    EXPECT_TRUE(sum.is_inward());
    EXPECT_LT(length(sum.area_vector) / sum.area, 0.1);  // both halves count alike
}

TEST(NormalEvidence, ConstantNormalsOfAnObjectAreOffItsSurface) {
    PointBlock block = sphere_at({}, 4000, false);
    for (Vec3f& normal : block.normal) normal = {0, 0, 1};
    EXPECT_TRUE(evidence_of_all(block).is_off_surface());
}

}  // namespace
}  // namespace slim::test
