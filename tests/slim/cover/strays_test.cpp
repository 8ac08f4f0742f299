#include "slim/cover/strays.h"

#include "tests/slim/cover/cover_support.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

// NUMERICS section 6, row 26: outliers, 5 and 20 %.

namespace slim::test {
namespace {

/// Whether the origin is a stray among points that `place` makes of three numbers in [-1, 1].
/// density: of strays
template <class Place>
bool is_stray(double radius, const Place& place, double density = 1e4) {
    std::vector<Vec3d> positions;
    for (std::uint64_t i = 0; i < 4000; ++i) {
        const Vec3d p = random_in_cube(1, i);
        positions.push_back(place(p.x, p.y, p.z));
    }
    std::vector<Vec3f> normals(positions.size(), Vec3f{0, 0, 1});
    const PointBlock block = block_of(std::move(positions), std::move(normals));
    BallPoints<double> ball;
    return stands_among_strays(tree_of(block), {0, 0, 0}, radius, density, ball);
}

TEST(Strays, FillSpaceOrLieOffASurface) {
    EXPECT_TRUE(is_stray(0.27, [](double x, double y, double z) { return Vec3d{x, y, z}; }));
    EXPECT_TRUE(
        is_stray(0.1, [](double x, double y, double) { return Vec3d{x, y, 0.12}; }));
}

TEST(Strays, AreHardlyDenserThanTheOthers) {
    const auto fill = [](double x, double y, double z) { return Vec3d{x, y, z}; };
    EXPECT_TRUE(is_stray(0.27, fill, 500));  // as these are
    EXPECT_FALSE(is_stray(0.27, fill, 2));  // a bush
}

TEST(Strays, ASurfaceAnEdgeALineOrTwoSheetsAreNone) {
    EXPECT_FALSE(is_stray(0.1, [](double x, double y, double) { return Vec3d{x, y, 0}; }));
    EXPECT_FALSE(is_stray(0.1, [](double x, double y, double z) {
        return Vec3d{x, y, 0.02 * z};  // noise
    }));
    EXPECT_FALSE(is_stray(0.1, [](double x, double y, double) {
        return Vec3d{std::max(x, 0.0), y, std::max(-x, 0.0)};  // a right angle
    }));
    EXPECT_FALSE(is_stray(0.1, [](double x, double y, double z) {
        return Vec3d{0.01 * x, 0.01 * y, z};  // a wire
    }));
    const auto two_sheets = [](double x, double y, double z) {
        return Vec3d{x, y, z > 0 ? 0 : -0.1};
    };
    EXPECT_FALSE(is_stray(0.1, two_sheets, 20));
    EXPECT_FALSE(is_stray(0.1, [](double x, double y, double) {
        return Vec3d{-std::abs(x), y, 0};  // a border
    }));
}

/// A sphere of radius 1 and strays in the box about it.
PointBlock sphere_with_strays(std::size_t n, std::size_t n_strays) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; i < n; ++i) {
        positions.push_back(random_direction(1, i));
        normals.push_back(to_float(positions.back()));
    }
    for (std::uint64_t i = 0; i < n_strays; ++i) {
        positions.push_back(random_in_cube(2, i));
        normals.push_back(to_float(random_direction(3, i)));
    }
    return block_of(std::move(positions), std::move(normals));
}

TEST(LevelCover, Row26HardlyAnythingStandsWhereOnlyStraysAre) {
    for (const std::size_t percent : {5u, 20u}) {
        SCOPED_TRACE(percent);
        constexpr std::size_t n = 20000;
        const PointBlock block = sphere_with_strays(n, n * percent / 100);
        CoverRules rules = rules_for(block, 0.01);
        rules.noise_variance = 1e-8;
        rules.spacing = std::sqrt(4 * std::numbers::pi / n);
        const auto count_away = [&](const Cover& c) {
            std::size_t n_away = 0;
            for (const FittedSurfel& f : leaves_of(c))
                n_away += std::abs(length(f.surfel.center) - 1) > 5 * rules.spacing;
            return n_away;
        };
        const std::size_t without = count_away(cover(block, rules));
        rules.stray_density = static_cast<double>(n * percent / 100) / 8;
        const Cover c = cover(block, rules);
        EXPECT_LT(5 * count_away(c), without);
        EXPECT_LE(c.counts.isolated, n * percent / 100);
    }
}

}  // namespace
}  // namespace slim::test
