#include "slim/tree/drawn_hull.h"

#include "slim/model/rim.h"
#include "slim/tree/drawn_bounds.h"
#include "slim/tree/hull_directions.h"
#include "slim/tree/leaf_places.h"
#include "tests/raytrace/support/analytic_models.h"
#include "tests/raytrace/support/sharp_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
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

/// All places of the leaves in the box.
std::vector<Vec3d> all_places(const SurfelTree& tree, bool loose, const Bbox& box) {
    std::vector<LeafPlace> places;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf() && tree.node(i).is_loose() == loose) {
            const Surfel leaf = tree.surfel(i);
            append_places(leaf, places);
            if (leaf.sharp || leaf.rims.any()) append_close_places(leaf, places);
        }
    std::vector<Vec3d> out;
    for (const LeafPlace& place : places) {
        Vec3d p = place.position;
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = std::clamp(p[axis], box.lo[axis], box.hi[axis]);
        out.push_back(p);
    }
    return out;
}

/// Each direction's farthest place is in the hull, as if every leaf had been looked at.
void expect_the_farthest(const SurfelTreeData& data, bool loose, const Bbox& box) {
    const std::vector<Vec3d> hull = drawn_hull(data.view(), loose, box),
                             all = all_places(data.view(), loose, box);
    ASSERT_FALSE(hull.empty());
    const HullDirections directions = HullDirections::all();
    ASSERT_EQ(directions.size(), 386u);
    for (std::size_t k = 0; k < directions.size(); ++k) {
        const Vec3d d = directions.at(k);
        // Along the axes hulls of what is not loose end at the box.
        const bool on_axis = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) == 1;
        if (on_axis && !loose) continue;
        EXPECT_GE(reach(hull, d), reach(all, d) - 1e-12) << k;
        if (loose) EXPECT_LE(reach(hull, d), reach(all, d) + 1e-12) << k;
    }
    if (loose) return;
    // The places moved onto the faces aside, no place is one that no leaf has.
    const auto n_strange = std::count_if(hull.begin(), hull.end(), [&](const Vec3d& p) {
        return std::find(all.begin(), all.end(), p) == all.end();
    });
    EXPECT_LE(n_strange, 6);
}

Bbox box_of(double x, double y, double z) {
    Bbox box;
    box.extend(Vec3d{-x, -y, -z}), box.extend(Vec3d{x, y, z});
    return box;
}

TEST(DrawnHull, HasTheFarthestPlacesOfAllLeaves) {
    // So small leaves that many are passed over, and so large ones that hardly any is.
    for (const std::size_t n : {7u, 300u, 5000u}) {
        SCOPED_TRACE(n);
        auto data = test::sphere_model(2, n);
        for (std::size_t i = 0; i < data.nodes.size(); i += 3)
            if (data.nodes[i].is_leaf()) data.nodes[i].flags |= kLoose;
        for (const bool loose : {false, true}) {
            expect_the_farthest(data, loose, box_of(3, 3, 3));
            // What lies beyond a face moves onto it, far off other directions' ways too.
            expect_the_farthest(data, loose, box_of(1.2, 3, 1.7));
        }
    }
    expect_the_farthest(test::torus_model(2, 0.7, 40, 20, 3), false, box_of(3, 3, 3));
    expect_the_farthest(test::torus_model(2, 0.7, 40, 20, 3), false, box_of(2.5, 2.9, 0.6));
}

TEST(DrawnHull, HasTheFarthestPlacesOfSharpAndOfCutOffLeaves) {
    expect_the_farthest(test::flat_tree(test::cube_leaves(), 2), false, box_of(2, 2, 2));
    auto data = test::sphere_model(2, 800);
    for (std::size_t i = 0; i < data.nodes.size(); i += 2)
        data.nodes[i].set_rims({pack_rim(0.37 * static_cast<double>(i), 0.1), 0});
    expect_the_farthest(data, false, box_of(3, 3, 3));
}

// Cameras that frame a part by its hull cut its corners off otherwise.
TEST(DrawnHull, HasACornerThatLiesBesideItsLeafsMiddle) {
    const std::array<Vec3d, 3> axes{test::axis_vector(0, 1), test::axis_vector(1, 1),
                                    test::axis_vector(2, 1)};
    const Vec3d diagonal = normalized(Vec3d{1, 1, 1});
    for (const double at : {0.1, 0.2, 0.28, 0.34, 0.39}) {  // each plane's distance from the middle
        Surfel corner = test::corner_surfel({0, 0, 0}, axes, 1);
        auto sheets = std::make_shared<SharpSheets>(*corner.sharp);
        corner.polynomial.a[0] = at;
        for (std::size_t i = 0; i < 2; ++i) sheets->extra[i].polynomial.a[0] = at;
        corner.sharp = sheets;
        const auto data = test::flat_tree({corner}, 2);
        EXPECT_GT(reach(drawn_hull(data.view(), false, box_of(at, at, at)), diagonal),
                  std::sqrt(3.0) * at - 0.02)
            << at;
    }
}

TEST(DrawnHull, HasTheFarthestPlacesOfSteepLeaves) {
    std::vector<Surfel> leaves;
    for (std::size_t i = 0; i < 400; ++i) {
        // Of the coefficients that fits may have (their sum is at most 3), off their centres too.
        Surfel s = test::sphere_surfel(test::fibonacci_point(i, 400), 1, 0.3, 3);
        for (std::size_t k = 0; k < 10; ++k)
            s.polynomial.a[k] = 0.6 * std::sin(static_cast<double>(7 * i + 3 * k * k));
        leaves.push_back(s);
    }
    expect_the_farthest(test::flat_tree(leaves, 3), false, box_of(3, 3, 3));
}

TEST(DrawnHull, LooksAtFewLeavesInFewDirections) {
    const auto data = test::two_level_sphere(2, 60, 20000);
    std::uint64_t n_tests = 0;
    drawn_hull(data.view(), false, box_of(3, 3, 3), &n_tests);
    EXPECT_GT(n_tests, 386u);
    // Neighbours in this file lie on a spiral, not side by side as in files of the tree stage.
    EXPECT_LT(n_tests, 20000u * 386u / 3);
}

}  // namespace
}  // namespace slim
