#include "raytrace/project/forward_renderer.h"

#include "slim/model/surfel_tree.h"
#include "tests/raytrace/support/analytic_models.h"
#include "tests/raytrace/support/iso_request.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

using test::iso_request;

TEST(ForwardRenderer, LevelOfDetailKeepsTheSilhouetteAndDrawsFewerSurfels) {
    const auto model = test::two_level_sphere(1, 1500, 12000);
    RenderRequest request = iso_request(model, 160, 160, true);
    request.camera.width = 12;  // a small sphere
    GBuffer full, coarse;
    const auto all = render_forward(model.view(), request, full);
    request.lod_px = 4;
    const auto cut = render_forward(model.view(), request, coarse);
    EXPECT_GT(all.surfels_drawn, 6000u);  // many lie between the pixels
    EXPECT_LE(cut.surfels_drawn, 1500u);
    EXPECT_LT(cut.nodes_visited, all.nodes_visited / 4);
    double area_full = 0, area_coarse = 0;
    for (std::size_t i = 0; i < full.n_pixels(); ++i) {
        area_full += full.hit[i];
        area_coarse += coarse.hit[i];
    }
    EXPECT_NEAR(std::sqrt(area_full / std::numbers::pi), 160 / 12.0, 1);
    EXPECT_NEAR(std::sqrt(area_coarse / std::numbers::pi), 160 / 12.0, 2);
}

/// 40 leaves of radius 0.02 below each of 1,500 surfels whose balls, of radius 0.07, cover the
/// sphere, but not their cores.
SurfelTreeData fine_sphere(bool marked) {
    constexpr float kShrunken = 0.55f;
    auto model = test::two_level_sphere(1, 1500, 60000);
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
        TreeNode& node = model.nodes[i];
        node.fit_error = 1e-5f;
        if (i == 0 || node.is_leaf()) continue;
        float* record = model.records.data() + 12 * i;
        for (const int k : {3, 9, 11}) record[k] *= kShrunken;  // radius, u^2, v^2
        if (marked) node.flags |= kStandsIn;
    }
    return model;
}

TEST(ForwardRenderer, StandInsLeaveNoHoles) {
    for (const double width : {8.9, 3.86}) {  // balls of 4 and 9 pixels
        const auto model = fine_sphere(true);
        RenderRequest request = iso_request(model, 250, 250, true);
        request.camera.width = width;
        request.wanted |= kDepthChannel;
        GBuffer full, coarse;
        request.lod_px = 0;
        render_forward(model.view(), request, full);
        request.lod_px = 4;
        const auto stats = render_forward(model.view(), request, coarse);
        EXPECT_LE(stats.surfels_drawn, 1500u) << width;
        std::size_t through = 0, n = 0;
        for (std::size_t i = 0; i < full.n_pixels(); ++i) {
            n += full.hit[i];
            through +=
                full.hit[i] && !(coarse.hit[i] && std::abs(full.depth[i] - coarse.depth[i]) < 0.5f);
        }
        EXPECT_GT(n, 1500u);
        EXPECT_EQ(through, 0u) << width;
    }
}

TEST(ForwardRenderer, LargerStandInsNeedTheMarkTheFitAndManyChildren) {
    const auto drawn = [](const SurfelTreeData& model, double width) {
        RenderRequest request = iso_request(model, 250, 250, true);
        request.camera.width = width;
        request.lod_px = 4;
        GBuffer out;
        return render_forward(model.view(), request, out).surfels_drawn;
    };
    EXPECT_EQ(drawn(fine_sphere(true), 3.86), 1500u);
    EXPECT_GT(drawn(fine_sphere(false), 3.86), 20000u);
    SurfelTreeData model = fine_sphere(true);
    for (TreeNode& node : model.nodes) node.fit_error = 0.002f;  // an eighth of a pixel
    EXPECT_GT(drawn(model, 3.86), 20000u);
    EXPECT_GT(drawn(fine_sphere(true), 2.2), 20000u);  // children of more than four pixels each
}

TEST(ForwardRenderer, APartOfAPictureOfStandInsIsThatOfTheWhole) {
    const auto model = fine_sphere(true);
    RenderRequest request = iso_request(model, 256, 256, false);
    request.lod_px = 8;
    GBuffer whole, part;
    render_forward(model.view(), request, whole);
    for (const PixelWindow w : {PixelWindow{64, 96, 64, 32}, PixelWindow{128, 128, 32, 64}}) {
        request.window = w;
        render_forward(model.view(), request, part);
        for (int y = 0; y < w.height; ++y)
            for (int x = 0; x < w.width; ++x)
                ASSERT_EQ(part.normal[0][part.index(x, y)],
                          whole.normal[0][whole.index(w.x + x, w.y + y)])
                    << x << ' ' << y;
    }
}

}  // namespace
}  // namespace slim
