#include "slim/base/hash.h"
#include "slim/cover/level_cover.h"
#include "slim/fit/sharp_search.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

constexpr double kThick = 0.1, kNoise = 0.0045, kSpacing = 0.02;

/// The two sides of a square plate and its rim, points and normals with noise.
PointBlock plate() {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    std::uint64_t key = 0;
    // of variance 1
    const auto noise = [&key] { return 3.46 * (unit_interval(keyed_hash(3, ++key)) - 0.5); };
    const auto add = [&](const Vec3d& p, const Vec3d& n) {
        positions.push_back(p + Vec3d{noise(), noise(), noise()} * kNoise);
        normals.push_back(to_float(normalized(n + Vec3d{noise(), noise(), noise()} * 0.2)));
    };
    const int n = static_cast<int>(1 / kSpacing), rows = static_cast<int>(kThick / kSpacing);
    for (int i = 0; i <= n; ++i)
        for (int k = 0; k <= n; ++k)
            for (const double side : {-1.0, 1.0})
                add({i * kSpacing, k * kSpacing, side * kThick / 2}, {0, 0, side});
    for (int i = 0; i <= n; ++i)
        for (int k = 1; k < rows; ++k)
            for (const double side : {-1.0, 1.0}) {
                const double at = i * kSpacing, z = k * kSpacing - kThick / 2, on = (1 + side) / 2;
                add({at, on, z}, {0, side, 0});
                add({on, at, z}, {side, 0, 0});
            }
    return block_of(std::move(positions), std::move(normals));
}

/// The mean angle between the smooth leaves in the middle of the plate's upper side and the side,
/// degrees.
double tilt_of(const Cover& c) {
    double sum = 0, n = 0;
    for (const FittedSurfel& f : leaves_of(c)) {
        const Vec3d& at = f.surfel.center;
        if (f.surfel.sharp || std::abs(at.x - 0.5) > 0.3 || std::abs(at.y - 0.5) > 0.3 || at.z < 0)
            continue;
        sum += std::acos(std::min(1.0, normalized(f.surfel.sheet_gradient(0, {})).z)) * 180 / M_PI,
            ++n;
    }
    return n > 0 ? sum / n : INFINITY;
}

TEST(LevelCover, ThePlatesOtherSideDoesNotMakeLeavesSmallInNoise) {
    const PointBlock block = plate();
    CoverRules rules = rules_for(block, 0.01);
    rules.noise_variance = rules.typical_variance = kNoise * kNoise;
    rules.spacing = kSpacing;
    rules.ladder.contrary_share = 2 * kCleanNormals;  // as noise leaves it: edges are in doubt
    const Cover smooth = cover(block, rules);
    rules.sharp = true;
    const Cover sharp = cover(block, rules);
    EXPECT_LT(sharp.counts.leaves, 0.6 * static_cast<double>(smooth.counts.leaves));
    // 2.8 where the other side ends the ladder (notes/0017)
    EXPECT_LT(tilt_of(smooth), 1.5);
    EXPECT_LT(tilt_of(sharp), 2);
    rules.ladder.contrary_share = 0;  // where edges are certain the rule has no part
    EXPECT_GT(tilt_of(cover(block, rules)), tilt_of(sharp));
}

}  // namespace
}  // namespace slim::test
