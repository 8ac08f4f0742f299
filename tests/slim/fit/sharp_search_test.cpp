#include "slim/fit/sharp_search.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

constexpr double kHalfWidth = 0.15;

/// A flat strip along y between two flat faces that fall away from it by 40 degrees.
PointBlock strip_points() {
    constexpr double kStep = 0.05, kSlope = 0.839, kCos = 0.766, kSin = 0.643;
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (int i = -20; i < 20; ++i)
        for (int j = -30; j < 30; ++j) {
            const double x = (i + 0.5) * kStep, y = (j + 0.5) * kStep;
            const double beyond = std::max(0.0, std::abs(x) - kHalfWidth);
            positions.push_back({x, y, -kSlope * beyond});
            normals.push_back(beyond > 0 ? Vec3f{static_cast<float>(std::copysign(kSin, x)), 0,
                                                 static_cast<float>(kCos)}
                                         : Vec3f{0, 0, 1});
        }
    return along_curve(block_of(std::move(positions), std::move(normals)));
}

TEST(SharpSearch, GoesOnWhereSheetsCostTooMuchForTheirSizeAlone) {
    const PointBlock block = strip_points();
    const PointPyramid pyramid(block, box_of(block), 1);
    const MdlEnergy energy{1e-4, 0.02};
    const SharpSearch search(pyramid, energy, 1e-12, 0.8, 2, {});
    LadderWork work;
    work.edge_in_sight = true;
    RadiusChoice smooth{0.16, 2};
    smooth.finest = 0.15;
    // What the first balls that see both edges cannot have for three sheets' price, wider ones can.
    smooth.energy = energy.price(0.28) * sharp_price(3);
    const auto found = search.choose({0.025, 0.025, 0}, smooth, work);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->n_sheets, 3u);
    EXPECT_GT(found->radius, 0.28);
}

}  // namespace
}  // namespace slim::test
