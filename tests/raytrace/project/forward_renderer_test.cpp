#include "raytrace/project/forward_renderer.h"

#include "slim/base/parallel.h"
#include "slim/model/surfel_tree.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace slim {
namespace {

RenderRequest request_for(const SurfelTreeData& model, int width, int height, bool orthographic) {
    RenderRequest request;
    Bbox box = model.header.bounds;
    Framing framing;
    framing.orthographic = orthographic;
    request.camera = named_camera("iso", box, double(width) / height, framing);
    request.width = width, request.height = height;
    request.wanted = kAllChannels;
    request.lod_px = 0;
    return request;
}

/// Distance from the ray of a pixel to the origin.
double ray_distance(const PixelView& view, int x, int y) {
    const Vec3d o = view.ray_origin(x + 0.5, y + 0.5), d = view.ray_direction(x + 0.5, y + 0.5);
    return length(o - d * dot(o, d));
}

/// Nearest point of the ray with the sphere about the origin.
Vec3d sphere_hit(const PixelView& view, int x, int y, double radius) {
    const Vec3d o = view.ray_origin(x + 0.5, y + 0.5), d = view.ray_direction(x + 0.5, y + 0.5);
    const Vec3d foot = o - d * dot(o, d);
    return foot - d * std::sqrt(radius * radius - sq_length(foot));
}

class SphereTest : public testing::TestWithParam<std::tuple<bool, int>> {};

TEST_P(SphereTest, HasTheRightSilhouetteDepthNormalsAndCurvature) {
    const auto [orthographic, degree] = GetParam();
    const double radius = 2;
    const auto model = test::sphere_model(radius, degree == 1 ? 4000 : 800, degree);
    const RenderRequest request = request_for(model, 300, 200, orthographic);
    GBuffer out;
    const RenderStats stats = render_forward(model.view(), request, out);
    const PixelView view = pixel_view(request.camera, 300, 200);
    const double pixel = 2.2 * radius / 200, position_tolerance = degree == 1 ? 8e-3 : 2e-3;
    std::uint64_t covered = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 300; ++x) {
            const std::size_t i = out.index(x, y);
            const double d = ray_distance(view, x, y);
            covered += out.hit[i];
            if (d < radius - pixel) { ASSERT_TRUE(out.hit[i]) << x << ' ' << y; }
            // Patches end at their trimmed ball, whose rim stands off the sphere.
            if (d > radius + pixel) { ASSERT_FALSE(out.hit[i]) << x << ' ' << y; }
            if (!out.hit[i] || d > 0.95 * radius) continue;
            const Vec3d expected = sphere_hit(view, x, y, radius);
            const Vec3d p{out.position[0][i], out.position[1][i], out.position[2][i]};
            const Vec3d n{out.normal[0][i], out.normal[1][i], out.normal[2][i]};
            ASSERT_LT(length(p - expected), position_tolerance * radius * 2) << x << ' ' << y;
            ASSERT_NEAR(length(n), 1, 1e-5);
            ASSERT_GT(dot(n, normalized(expected)), degree == 1 ? 0.999 : 0.9999);
            ASSERT_NEAR(out.depth[i], dot(p - view.eye, view.forward), 1e-4);
            ASSERT_GT(out.coverage[i], 0.1f);
            ASSERT_GE(out.count[i], 1u);
            ASSERT_EQ(out.level[i], 3.0f);
            ASSERT_FLOAT_EQ(out.fit_error[i], 0.001f * static_cast<float>(out.surfel_id[i]));
            if (degree == 1) continue;
            ASSERT_NEAR(out.mean[i], 1 / radius, 0.04 / radius);
            ASSERT_NEAR(out.gauss[i], 1 / (radius * radius), 0.08 / (radius * radius));
            ASSERT_GE(out.k1[i], out.k2[i]);
        }
    EXPECT_EQ(stats.covered_pixels, covered);
    EXPECT_GT(covered, 5000u);
    EXPECT_LE(stats.unblended_pixels, covered / 10000);
    EXPECT_GT(stats.root_tests, covered);
}

INSTANTIATE_TEST_SUITE_P(ForwardRenderer, SphereTest,
                         testing::Combine(testing::Bool(), testing::Values(1, 2, 3)));

TEST(ForwardRenderer, DrawsATorusWithItsCurvature) {
    const double big = 2, small = 0.7;
    std::array<double, 4> error{};
    for (const int degree : {2, 3}) {
        const auto model = test::torus_model(big, small, 192, 72, degree);
        const RenderRequest request = request_for(model, 320, 240, false);
        GBuffer out;
        render_forward(model.view(), request, out);
        const Vec3d eye = request.camera.eye;
        double sum = 0, sum_k1 = 0;
        int n = 0;
        for (std::size_t i = 0; i < out.n_pixels(); ++i) {
            const Vec3d normal{out.normal[0][i], out.normal[1][i], out.normal[2][i]};
            // Near the silhouette a patch's rim stands off the torus by more.
            const double x = out.position[0][i], y = out.position[1][i], z = out.position[2][i];
            if (!out.hit[i] || dot(normal, normalized(eye - Vec3d{x, y, z})) < 0.3) continue;
            const double ring = std::hypot(x, y), b = std::atan2(z, ring - big);
            ASSERT_NEAR(std::hypot(ring - big, z), small, 0.005);
            sum_k1 += std::abs(out.k1[i] - 1 / small);
            sum += std::abs(out.k2[i] - std::cos(b) / ring);
            ++n;
        }
        EXPECT_GT(n, 10000);
        error[static_cast<std::size_t>(degree)] = sum / n;
        // A parabola's curvature falls by (1 + u^2 / r^2)^-3/2 from its centre.
        EXPECT_LT(sum_k1 / n, 0.05);
    }
    EXPECT_LT(error[2], 0.005);
    // The cubic term is the change of curvature along the tube; most of it cancels in the blend.
    EXPECT_LT(error[3], 0.9 * error[2]);
}

TEST(ForwardRenderer, GivesTheSameBytesForAnyNumberOfThreads) {
    const auto model = test::sphere_model(1, 2000);
    const RenderRequest request = request_for(model, 333, 211, false);
    std::vector<GBuffer> buffers(3);
    const int threads[] = {1, 2, 7};
    for (std::size_t i = 0; i < 3; ++i) {
        const ThreadLimit limit(threads[i]);
        render_forward(model.view(), request, buffers[i]);
    }
    for (std::size_t i = 1; i < 3; ++i) {
        EXPECT_EQ(buffers[0].hit, buffers[i].hit);
        EXPECT_EQ(buffers[0].depth, buffers[i].depth);
        EXPECT_EQ(buffers[0].position, buffers[i].position);
        EXPECT_EQ(buffers[0].normal, buffers[i].normal);
        EXPECT_EQ(buffers[0].k1, buffers[i].k1);
        EXPECT_EQ(buffers[0].gauss, buffers[i].gauss);
        EXPECT_EQ(buffers[0].coverage, buffers[i].coverage);
        EXPECT_EQ(buffers[0].surfel_id, buffers[i].surfel_id);
    }
}

TEST(ForwardRenderer, AWindowEqualsTheCropOfTheWholePicture) {
    const auto model = test::sphere_model(1, 1000);
    RenderRequest request = request_for(model, 200, 150, false);
    GBuffer whole, part;
    render_forward(model.view(), request, whole);
    for (const PixelWindow w : {PixelWindow{100, 75, 1, 1}, PixelWindow{97, 3, 1, 140},
                                PixelWindow{13, 60, 170, 1}, PixelWindow{33, 21, 70, 90}}) {
        request.window = w;
        render_forward(model.view(), request, part);
        ASSERT_EQ(part.width, w.width);
        for (int y = 0; y < w.height; ++y)
            for (int x = 0; x < w.width; ++x) {
                const std::size_t i = part.index(x, y), j = whole.index(w.x + x, w.y + y);
                ASSERT_EQ(part.hit[i], whole.hit[j]);
                ASSERT_EQ(part.depth[i], whole.depth[j]);
                ASSERT_EQ(part.normal[1][i], whole.normal[1][j]);
                ASSERT_EQ(part.k1[i], whole.k1[j]);
                ASSERT_EQ(part.surfel_id[i], whole.surfel_id[j]);
            }
    }
}

TEST(ForwardRenderer, SeesTheSameSphereFromAMillionDiagonals) {
    const auto model = test::sphere_model(1, 1000);
    RenderRequest request = request_for(model, 160, 160, false);
    const double far = 2e6 * std::sqrt(3.0);
    request.camera.eye = Vec3d{0, 0, far};
    request.camera.target = {};
    request.camera.fov_y_deg = 2 * std::atan(1.1 / far) * 180 / std::numbers::pi;
    GBuffer perspective, parallel;
    render_forward(model.view(), request, perspective);
    request.camera.orthographic = true;
    request.camera.width = 2.2;
    render_forward(model.view(), request, parallel);
    std::size_t different = 0, covered = 0;
    for (std::size_t i = 0; i < perspective.n_pixels(); ++i) {
        covered += parallel.hit[i];
        if (perspective.hit[i] != parallel.hit[i]) ++different;
        else if (std::abs(perspective.position[2][i] - parallel.position[2][i]) > 1e-4) ++different;
    }
    EXPECT_GT(covered, 15000u);
    EXPECT_LE(different, 4u);
}

TEST(ForwardRenderer, LevelOfDetailKeepsTheSilhouetteAndDrawsFewerSurfels) {
    const auto model = test::two_level_sphere(1, 1500, 12000);
    RenderRequest request = request_for(model, 160, 160, true);
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

/// 40 leaves of radius 0.02 below each of 1,500 surfels whose balls, of radius 0.07, cover the sphere, but
/// not their cores.
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
        RenderRequest request = request_for(model, 250, 250, true);
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
            through += full.hit[i] && !(coarse.hit[i] && std::abs(full.depth[i] - coarse.depth[i]) < 0.5f);
        }
        EXPECT_GT(n, 1500u);
        EXPECT_EQ(through, 0u) << width;
    }
}

TEST(ForwardRenderer, LargerStandInsNeedTheMarkTheFitAndManyChildren) {
    const auto drawn = [](const SurfelTreeData& model, double width) {
        RenderRequest request = request_for(model, 250, 250, true);
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
    RenderRequest request = request_for(model, 256, 256, false);
    request.lod_px = 8;
    GBuffer whole, part;
    render_forward(model.view(), request, whole);
    for (const PixelWindow w : {PixelWindow{64, 96, 64, 32}, PixelWindow{128, 128, 32, 64}}) {
        request.window = w;
        render_forward(model.view(), request, part);
        for (int y = 0; y < w.height; ++y)
            for (int x = 0; x < w.width; ++x)
                ASSERT_EQ(part.normal[0][part.index(x, y)], whole.normal[0][whole.index(w.x + x, w.y + y)])
                    << x << ' ' << y;
    }
}

TEST(ForwardRenderer, AllocatesAndWritesOnlyWhatIsWanted) {
    const auto model = test::sphere_model(1, 500);
    RenderRequest request = request_for(model, 64, 64, false);
    request.wanted = kNormalChannel;
    GBuffer out;
    const auto stats = render_forward(model.view(), request, out);
    EXPECT_GT(stats.covered_pixels, 0u);
    EXPECT_TRUE(out.depth.empty());
    EXPECT_TRUE(out.k1.empty());
    EXPECT_TRUE(out.position[0].empty());
    EXPECT_EQ(out.normal[2].size(), 64u * 64u);
}

TEST(ForwardRenderer, CullsWhatIsOutsideTheViewOrBehindTheCamera) {
    const auto model = test::sphere_model(1, 500);
    RenderRequest request = request_for(model, 64, 64, false);
    request.camera.target = request.camera.eye * 2.0;
    GBuffer out;
    const auto stats = render_forward(model.view(), request, out);
    EXPECT_EQ(stats.surfels_drawn, 0u);
    EXPECT_EQ(stats.covered_pixels, 0u);
    EXPECT_EQ(stats.nodes_visited, 1u);
}

TEST(ForwardRenderer, TheNearPlaneOpensTheSphere) {
    const auto model = test::sphere_model(1, 1000);
    RenderRequest request = request_for(model, 64, 64, false);
    request.camera.eye = request.camera.eye - request.camera.target, request.camera.target = {};  // at the centre
    const PixelView view = pixel_view(request.camera, 64, 64);
    request.camera.near_plane = length(request.camera.eye);  // through the centre: the inside is seen
    GBuffer out;
    render_forward(model.view(), request, out);
    const std::size_t i = out.index(32, 32);
    ASSERT_TRUE(out.hit[i]);
    const Vec3d n{out.normal[0][i], out.normal[1][i], out.normal[2][i]};
    EXPECT_GT(dot(n, view.forward), 0.99);
    EXPECT_NEAR(out.depth[i], length(request.camera.eye) + 1, 0.01);
}

TEST(ForwardRenderer, AnEmptyTreeGivesAnEmptyPicture) {
    SurfelTreeData model;
    GBuffer out;
    RenderRequest request;
    request.width = request.height = 8;
    EXPECT_EQ(render_forward(model.view(), request, out).covered_pixels, 0u);
    EXPECT_EQ(out.hit.size(), 64u);
}

}  // namespace
}  // namespace slim
