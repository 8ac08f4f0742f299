#include "raytrace/project/forward_renderer.h"

#include "slim/base/parallel.h"
#include "slim/model/surfel_tree.h"
#include "tests/raytrace/support/analytic_models.h"
#include "tests/raytrace/support/iso_request.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace slim {
namespace {

using test::iso_request;

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
    const RenderRequest request = iso_request(model, 300, 200, orthographic);
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
        const RenderRequest request = iso_request(model, 320, 240, false);
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
    const RenderRequest request = iso_request(model, 333, 211, false);
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
    RenderRequest request = iso_request(model, 200, 150, false);
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
    RenderRequest request = iso_request(model, 160, 160, false);
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

TEST(ForwardRenderer, AllocatesAndWritesOnlyWhatIsWanted) {
    const auto model = test::sphere_model(1, 500);
    RenderRequest request = iso_request(model, 64, 64, false);
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
    RenderRequest request = iso_request(model, 64, 64, false);
    request.camera.target = request.camera.eye * 2.0;
    GBuffer out;
    const auto stats = render_forward(model.view(), request, out);
    EXPECT_EQ(stats.surfels_drawn, 0u);
    EXPECT_EQ(stats.covered_pixels, 0u);
    EXPECT_EQ(stats.nodes_visited, 1u);
}

TEST(ForwardRenderer, TheNearPlaneOpensTheSphere) {
    const auto model = test::sphere_model(1, 1000);
    RenderRequest request = iso_request(model, 64, 64, false);
    request.camera.eye = request.camera.eye - request.camera.target;
    request.camera.target = {};  // at the centre
    const PixelView view = pixel_view(request.camera, 64, 64);
    // through the centre: the inside is seen
    request.camera.near_plane = length(request.camera.eye);
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
