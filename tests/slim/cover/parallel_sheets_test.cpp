#include "slim/base/hash.h"
#include "slim/cover/level_cover.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

// NUMERICS section 6, row 20: two sheets that face away from each other.

namespace slim::test {
namespace {

constexpr std::uint64_t kPoints = 20000;
constexpr double kSpacing = 0.014;  // of a sheet's points: kPoints / 2 over [0, 1] x [0, 2]

struct Walls {
    double gap, noise;
};

/// Two walls of 1 by 2 with points at random and noise across.
PointBlock points_of(const Walls& walls) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const auto random = [](std::uint64_t key, std::uint64_t i) {
        return unit_interval(keyed_hash(key, i));
    };
    for (std::uint64_t i = 0; i < kPoints; ++i) {
        const double side = i % 2 == 0 ? 1 : -1;
        double off = -2;  // of variance 1
        for (std::uint64_t k = 0; k < 4; ++k) off += random(3 + k, i);
        const double z = side * walls.gap / 2 + off * std::sqrt(3.0) * walls.noise;
        positions.push_back({random(1, i), 2 * random(2, i), z});
        normals.push_back({0, 0, static_cast<float>(side)});
    }
    return block_of(std::move(positions), std::move(normals));
}

Cover cover_of(const Walls& walls) {
    const PointBlock block = points_of(walls);
    CoverRules rules = rules_for(block);
    rules.noise_variance = walls.noise * walls.noise;
    return cover(block, rules);
}

/// RMS angle between the walls and the leaves away from their borders, where both end, degrees.
double tilt_of(const Cover& c) {
    double sum = 0, n = 0;
    for (const FittedSurfel& f : leaves_of(c)) {
        const Vec3d& at = f.surfel.center;
        if (std::abs(at.x - 0.5) > 0.35 || std::abs(at.y - 1) > 0.85) continue;
        const double along = normalized(f.surfel.sheet_gradient(0, {})).z;
        sum += 1 - along * along, ++n;
    }
    return std::sqrt(sum / n) * 180 / M_PI;
}

TEST(LevelCover, Row20NoisySheetsCloseToEachOtherAreNotFittedByTinyLeaves) {
    constexpr double noise = 0.15 * kSpacing;
    const Cover apart = cover_of({100 * kSpacing, noise});
    for (const double gap : {7.0, 3.0, 1.5}) {  // in spacings; ten noises and more
        SCOPED_TRACE(gap);
        const Cover close = cover_of({gap * kSpacing, noise});
        EXPECT_LT(static_cast<double>(close.counts.leaves),
                  2 * static_cast<double>(apart.counts.leaves));
        EXPECT_LT(tilt_of(close), 1.5 * tilt_of(apart));
    }
}

TEST(LevelCover, Row20SheetsCloserThanThePointsHaveLargeLeavesOfTheirOwn) {
    constexpr double gap = 0.4 * kSpacing;
    const Walls walls{gap, 0.1 * gap};
    const Cover close = cover_of(walls), apart = cover_of({100 * kSpacing, walls.noise});
    EXPECT_LT(static_cast<double>(close.counts.leaves),
              2.5 * static_cast<double>(apart.counts.leaves));
    for (const FittedSurfel& f : leaves_of(close)) {
        const double side = f.surfel.frame.normal.z > 0 ? 1 : -1;
        const Vec3d foot = f.surfel.center + f.surfel.frame.normal * (f.surfel.polynomial.a[0] *
                                                                      f.surfel.support_radius);
        ASSERT_NEAR(foot.z, side * gap / 2, 0.25 * gap);
    }
}

TEST(LevelCover, Row20ASheetThatTurnsRoundEndsThere) {
    // Both walls end at y = 2, as a blade does: no leaf stands out farther than those of one wall.
    const double noise = 1e-4 * kSpacing;
    const auto reach_of = [&](double gap) {
        double reach = 0;
        for (const FittedSurfel& f : leaves_of(cover_of({gap, noise})))
            reach = std::max(reach, f.surfel.center.y + 0.7 * f.surfel.support_radius - 2);
        return reach;
    };
    EXPECT_LT(reach_of(2 * kSpacing), 1.2 * reach_of(100 * kSpacing));
}

TEST(LevelCover, Row21LeavesBetweenTwoLayersAreCounted) {
    const auto counted = [](double gap, double noise, bool with_normals) {
        PointBlock block = points_of({gap, noise});
        if (!with_normals)
            for (Vec3f& normal : block.normal) normal = {0, 0, 1};  // as estimates have it
        const Cover c = cover(block, rules_for(block));
        return static_cast<double>(c.counts.two_layers) / static_cast<double>(c.counts.leaves);
    };
    constexpr double gap = 0.4 * kSpacing;
    EXPECT_GT(counted(gap, 0.1 * gap, false), 0.5);
    EXPECT_EQ(counted(gap, 0.1 * gap, true), 0);
    EXPECT_EQ(counted(0, 0.1 * gap, false), 0);  // one sheet with noise
}

}  // namespace
}  // namespace slim::test
