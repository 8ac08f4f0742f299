#include "raytrace/project/lod_cut.h"

#include "tests/raytrace/support/analytic_models.h"
#include "tests/raytrace/support/iso_request.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// As trees of older programs say: what is below each 50th coarse ball reaches seven radii far.
SurfelTreeData with_far_leaves() {
    SurfelTreeData model = test::two_level_sphere(1, 1500, 12000);
    const SurfelTree tree = model.view();
    for (std::size_t i = 1; i < model.nodes.size(); i += 50) {
        TreeNode& node = model.nodes[i];
        if (node.is_leaf() || node.n_children == 0) continue;
        node.bound_radius = static_cast<float>(7 * tree.support_radius(i));
    }
    return model;
}

std::vector<std::uint32_t> cut_of(const SurfelTreeData& model) {
    RenderRequest request = test::iso_request(model, 160, 160, true);
    request.camera.width = 12;
    const PixelView view = pixel_view(request.camera, 160, 160);
    CutCounts counts;
    return lod_cut(model.view(), view, {0, 0, 160, 160}, {4}, counts);
}

TEST(LodCut, NoBallStandsInForLeavesFarFromIt) {
    const SurfelTreeData near = test::two_level_sphere(1, 1500, 12000), far = with_far_leaves();
    const auto is_internal = [&](std::uint32_t i) { return !near.nodes[i].is_leaf(); };
    const auto before = cut_of(near), after = cut_of(far);
    ASSERT_TRUE(std::all_of(before.begin(), before.end(), is_internal));
    std::vector<std::uint32_t> expected;  // their children instead
    for (const std::uint32_t i : before) {
        const TreeNode& node = far.nodes[i];
        if (i % 50 != 1 || node.n_children == 0) {
            expected.push_back(i);
            continue;
        }
        for (std::uint32_t c = 0; c < node.n_children; ++c)
            expected.push_back(node.first_child + c);
    }
    EXPECT_GT(expected.size(), before.size());
    auto sorted = after;
    std::sort(sorted.begin(), sorted.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(sorted, expected);
}

TEST(LodCut, ABallOffTheMiddleIsAsLargeAsItsPicture) {
    Camera camera;
    camera.eye = {0, 0, 0}, camera.target = {0, 0, -1}, camera.fov_y_deg = 150;
    const PixelView view = pixel_view(camera, 400, 400);
    constexpr double kRadius = 0.01;
    for (const double angle : {0.0, 0.5, 1.0, 1.3}) {
        SCOPED_TRACE(angle);
        // Where rays that touch the ball cut the picture, on the line from its middle.
        const double distance = 3, half = std::asin(kRadius / distance);
        const double reach = std::tan(angle + half) - std::tan(angle - half);
        const Vec3d center{distance * std::sin(angle), 0, distance * std::cos(angle)};
        EXPECT_NEAR(projected_diameter(view, center, kRadius) / (view.focal_px * reach), 1, 1e-3);
    }
    EXPECT_TRUE(std::isinf(projected_diameter(view, {3, 0, 0.005}, kRadius)));
}

}  // namespace
}  // namespace slim
