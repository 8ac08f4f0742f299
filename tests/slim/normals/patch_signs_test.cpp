#include "slim/normals/patch_signs.h"

#include "slim/base/parallel.h"
#include "slim/normals/repair.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace slim::test {
namespace {

/// A checkered solid, its normals flipped where sin x sin y sin z exceeds `least`.
bool is_flipped(const Vec3d& p, double least) {
    return std::sin(5 * p.x) * std::sin(5 * p.y) * std::sin(5 * p.z + 1) > least;
}

PointBlock with_flipped_patches(const char* shape, double least, double noise = 0) {
    PointBlock block = along_curve(block_of(sampled(shape, 40000, 1, noise)));
    for (std::size_t i = 0; i < block.size(); ++i)
        if (is_flipped(block.position[i], least)) block.normal[i] = -block.normal[i];
    return block;
}

bool has_seams(PointBlock block) {
    return repair_contrary_normals(
               block, BoxTree(block.size(), [&](std::size_t i) { return block.position[i]; }))
        .has_seams();
}

// NUMERICS section 6, 27: normals flipped 1..50 %.
TEST(PatchSigns, Row27PatchesOfFlippedNormalsAreFound) {
    for (const char* shape : {"sphere", "bumpy", "torus", "sculpture"}) {
        for (const double least : {0.0, 0.3, 0.6}) {  // nearly half to some percent
            SCOPED_TRACE(testing::Message() << shape << " " << least);
            const PointBlock block = with_flipped_patches(shape, least);
            EXPECT_TRUE(has_seams(block));
            const ContraryPatches found =
                contrary_patches(block, NearestSearch(block.position));
            ASSERT_EQ(found.is_contrary.size(), block.size());
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < block.size(); ++i)
                wrong += found.is_contrary[i] != is_flipped(block.position[i], least);
            // Specks of fewer than 50 points; of half of the sculpture, whose steps say little,
            // whole patches.
            const bool has_steps = std::string(shape) == "sculpture";
            EXPECT_LT(wrong, block.size() / (has_steps && least == 0 ? 15 : 200));
        }
    }
}

TEST(PatchSigns, RightNormalsHaveNone) {
    for (const char* shape : {"sphere", "sculpture", "bumpy"}) {
        for (const double noise : {0.0, 0.005}) {
            const PointBlock block = along_curve(block_of(sampled(shape, 40000, 1, noise)));
            EXPECT_EQ(contrary_patches(block, NearestSearch(block.position)).n, 0u) << shape;
        }
    }
}

TEST(PatchSigns, PlainSurfacesNeedNoCloserLook) {
    for (const char* shape : {"sphere", "bumpy", "torus"})
        EXPECT_FALSE(has_seams(along_curve(block_of(sampled(shape, 40000, 1, 0.001))))) << shape;
}

/// Both sides of the square [-1, 1]^2, `gap` from each other, with noise.
PointBlock sheet(double gap, double noise) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < 40000; ++i) {
        const double side = i % 2 == 0 ? 1 : -1;
        positions.push_back({random_at(1, 2 * i), random_at(1, 2 * i + 1),
                             side * gap / 2 + noise * gaussian(3, i)});
        normals.push_back({0, 0, static_cast<float>(side)});
    }
    return along_curve(block_of(positions, normals));
}

// NUMERICS section 6, 20: the sides lie above each other, not beside.
TEST(PatchSigns, Row20TheSidesOfAThinSheetAreNoPatches) {
    for (const double gap : {0.0, 0.001, 0.01, 0.03}) {
        for (const double noise : {0.0, 0.002}) {
            SCOPED_TRACE(testing::Message() << gap << " " << noise);
            if (gap == 0 && noise == 0) continue;
            const PointBlock block = sheet(gap, noise);
            EXPECT_EQ(contrary_patches(block, NearestSearch(block.position)).n, 0u);
        }
    }
}

TEST(PatchSigns, TheSidesOfAKnifeAndOfACreaseAreNoPatches) {
    // Two planes that meet in a line at 10 degrees, normals out of the wedge or into it.
    for (const double out : {1.0, -1.0}) {
        std::vector<Vec3d> positions;
        std::vector<Vec3f> normals;
        const double slope = std::tan(5 * std::numbers::pi / 180);
        for (std::size_t i = 0; i < 40000; ++i) {
            const double side = i % 2 == 0 ? 1 : -1, x = 0.5 + 0.5 * random_at(1, 2 * i);
            positions.push_back({x, random_at(1, 2 * i + 1), side * slope * x});
            normals.push_back(normalized(to_float(out * Vec3d{-slope, 0, side})));
        }
        const PointBlock block = along_curve(block_of(positions, normals));
        EXPECT_EQ(contrary_patches(block, NearestSearch(block.position)).n, 0u) << out;
    }
}

TEST(PatchSigns, OfAlmostEqualSidesTheOneThatFacesInIsContrary) {
    PointBlock block = along_curve(block_of(sampled("sphere", 20000)));
    std::size_t n = 0;
    for (std::size_t i = 0; i < block.size(); ++i)
        if (block.position[i].z > -0.2) block.normal[i] = -block.normal[i], ++n;
    EXPECT_GT(n, block.size() / 2);
    const ContraryPatches found = contrary_patches(block, NearestSearch(block.position));
    EXPECT_EQ(found.n, n);
    for (std::size_t i = 0; i < block.size(); ++i)
        ASSERT_EQ(found.is_contrary[i], block.position[i].z > -0.2);
}

TEST(PatchSigns, AreTheSameForAnyNumberOfThreads) {
    const PointBlock block = with_flipped_patches("sculpture", 0.1, 0.002);
    std::vector<std::vector<bool>> found;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        found.push_back(contrary_patches(block, NearestSearch(block.position)).is_contrary);
    }
    EXPECT_EQ(found[0], found[1]);
    EXPECT_EQ(found[0], found[2]);
    EXPECT_FALSE(found[0].empty());
}

}  // namespace
}  // namespace slim::test
