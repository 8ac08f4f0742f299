#include "slim/tree/drawn_hull.h"

#include "slim/tree/drawn_bounds.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

double reach(const std::vector<Vec3d>& places, const Vec3d& direction) {
    double most = -INFINITY;
    for (const Vec3d& p : places) most = std::max(most, dot(p, direction));
    return most;
}

std::vector<Vec3d> directions() {
    std::vector<Vec3d> out;
    for (int i = 0; i < 500; ++i) {  // of a spiral over the sphere
        const double z = 1 - (2 * i + 1) / 500.0, r = std::sqrt(1 - z * z);
        out.push_back({r * std::cos(2.4 * i), r * std::sin(2.4 * i), z});
    }
    return out;
}

TEST(DrawnHull, OfASphereIsTheSphereInAllDirections) {
    auto data = test::sphere_model(2, 600);
    set_drawn_bounds(data);
    EXPECT_LE(data.header.hull.size(), 386u);
    EXPECT_TRUE(data.header.loose_hull.empty());
    for (const Vec3d& d : directions()) {
        EXPECT_GT(reach(data.header.hull, d), 2 * (1 - 0.02));
        EXPECT_LT(reach(data.header.hull, d), 2 * (1 + 0.005));
    }
    for (const std::size_t axis : {0u, 1u, 2u}) {
        Vec3d d;
        d[axis] = 1;
        EXPECT_EQ(reach(data.header.hull, d), data.header.drawn.hi[axis]);
        EXPECT_EQ(-reach(data.header.hull, -d), data.header.drawn.lo[axis]);
    }
}

TEST(DrawnHull, HoldsOnlyWhatIsDrawn) {
    auto data = test::sphere_model(2, 600);
    // Half of the sphere is loose, and no surfel but a leaf counts.
    for (std::size_t i = 0; i < data.nodes.size(); ++i)
        if (data.nodes[i].is_leaf() && data.view().center(i).x > 0) data.nodes[i].flags |= kLoose;
    set_drawn_bounds(data);
    EXPECT_LT(reach(data.header.hull, {1, 0, 0}), 0.5);
    EXPECT_GT(reach(data.header.loose_hull, {1, 0, 0}), 1.95);
    EXPECT_GT(-reach(data.header.loose_hull, {-1, 0, 0}), -0.5);
}

}  // namespace
}  // namespace slim
