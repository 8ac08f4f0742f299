#include "slim/fit/sharp_search.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

constexpr double kHalfWidth = 0.15;

/// A strip along y, flat or raised by `ripple` at every other point, between two flat faces that
/// fall away from it by 40 degrees.
PointBlock strip_points(double ripple = 0) {
    constexpr double kStep = 0.05, kSlope = 0.839, kCos = 0.766, kSin = 0.643;
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (int i = -20; i < 20; ++i)
        for (int j = -30; j < 30; ++j) {
            const double x = (i + 0.5) * kStep, y = (j + 0.5) * kStep;
            const double beyond = std::max(0.0, std::abs(x) - kHalfWidth);
            positions.push_back({x, y, -kSlope * beyond + ((i + j) % 2 ? ripple : 0)});
            normals.push_back(beyond > 0 ? Vec3f{static_cast<float>(std::copysign(kSin, x)), 0,
                                                 static_cast<float>(kCos)}
                                         : Vec3f{0, 0, 1});
        }
    return along_curve(block_of(std::move(positions), std::move(normals)));
}

/// What is found of it where a smooth leaf costs as much as three sheets with a radius of 0.28: a
/// bent one, or, with a smaller radius, a price alone.
std::optional<SharpSearch::Choice> found_of(const PointBlock& block, double smooth_radius = 0.24) {
    const PointPyramid pyramid(block, box_of(block), 1);
    const MdlEnergy energy{1e-4, 0.02};
    const SharpSearch search(pyramid, energy, 1e-12, 0.8, 2, {});
    LadderWork work;
    work.edge_in_sight = true;
    RadiusChoice smooth{smooth_radius, 2};
    smooth.finest = 0.15;
    smooth.energy = energy.price(0.28) * sharp_price(3);
    return search.choose({0.025, 0.025, 0}, smooth, work);
}

TEST(SharpSearch, GoesOnWhereSheetsCostTooMuchForTheirSizeAlone) {
    // What the first balls that see both edges cannot have for that price, wider ones can.
    const auto found = found_of(strip_points());
    ASSERT_TRUE(found);
    EXPECT_EQ(found->n_sheets, 3u);
    EXPECT_GT(found->radius, 0.28);
}

TEST(SharpSearch, SheetsThatFitPoorlyAreNotLookedForInWiderBalls) {
    EXPECT_FALSE(found_of(strip_points(0.001)));
}

TEST(SharpSearch, ASmoothLeafThatIsExactStays) { EXPECT_FALSE(found_of(strip_points(), 0.16)); }

}  // namespace
}  // namespace slim::test
