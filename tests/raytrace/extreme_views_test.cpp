// NUMERICS section 6, rows 36 to 43: views that strain projection.
#include "raytrace/brute/brute_renderer.h"
#include "raytrace/lines/extract.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/error.h"
#include "slim/blend/roots.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr Channels kWanted = kDepthChannel | kPositionChannel | kNormalChannel;

RenderRequest request_at(const Vec3d& eye, const Vec3d& target, double fov_deg, int width,
                         int height) {
    RenderRequest request;
    request.camera.eye = eye, request.camera.target = target;
    request.camera.up = {0.1, 1, 0.05};
    request.camera.fov_y_deg = fov_deg;
    request.width = width, request.height = height;
    request.wanted = kWanted;
    request.lod_px = 0;
    return request;
}

struct Difference {
    std::size_t covered = 0, hits = 0;  ///< pixels that both cover, that one covers alone
    double depth = 0;                   ///< largest, over the depth
};

/// The forward renderer against the one in doubles without tiles, levels or lanes.
Difference against_brute(const SurfelTreeData& model, const RenderRequest& request) {
    GBuffer fast, slow;
    render_forward(model.view(), request, fast);
    render_brute(model.view(), request, slow);
    Difference d;
    for (std::size_t i = 0; i < fast.n_pixels(); ++i) {
        d.hits += fast.hit[i] != slow.hit[i];
        if (!fast.hit[i] || !slow.hit[i]) continue;
        ++d.covered;
        d.depth = std::max(
            d.depth, static_cast<double>(std::abs(fast.depth[i] - slow.depth[i]) / slow.depth[i]));
    }
    return d;
}

// Near a double root every method is limited to the square root of the rounding: 3e-4 in floats.
constexpr double kReach = 4e-4;

TEST(ExtremeViews, Row36TangentRaysHitOrMissWithinSqrtOfRounding) {
    for (int i = -100; i <= 100; ++i) {
        // The paraboloid w = -t^2 / 2 along a level ray at height h: tangent at h = 0.
        const float h = static_cast<float>(i) * 1e-9f;
        const auto roots = quadratic_roots<float>(h, 0, 0.5f, -1, 1);
        const double exact = h <= 0 ? std::sqrt(-2.0 * static_cast<double>(h)) : 0;
        if (roots.n == 0) {
            EXPECT_GT(h, 0) << i;
            continue;
        }
        for (int k = 0; k < roots.n; ++k)
            EXPECT_NEAR(std::abs(static_cast<double>(roots.t[static_cast<std::size_t>(k)])), exact,
                        kReach)
                << i;
    }
    // In the picture: a ray farther than that from the rim of the cap is decided as the exact one.
    const auto model = test::sphere_model(1, 3000);
    const RenderRequest request = request_at({0, 0, 6}, {}, 20, 400, 400);
    const Difference d = against_brute(model, request);
    EXPECT_GT(d.covered, 10000u);
    EXPECT_LE(d.hits, 2u);
}

/// The same paraboloid as a surfel of radius 1, seen along its tangent plane:
/// rows of the picture lie 2e-8 apart.
TEST(ExtremeViews, Row36TangentRaysOfTheRenderersKernels) {
    constexpr int kRows = 201;
    constexpr double kStep = 2e-8;
    for (const int degree : {2, 3}) {
        Surfel cap{{}, 1, frame_from_normal(round_normal({0, 0, 1})), {}, degree};
        cap.polynomial.a[3] = cap.polynomial.a[5] = -0.5;
        const auto model = test::flat_tree({cap}, degree);
        RenderRequest request = request_at({4, 0, 0}, {0, 0, 0}, 35, 16, kRows);
        request.camera.up = {0, 0, 1};
        request.camera.orthographic = true, request.camera.width = 16 * kStep;
        GBuffer out;
        render_forward(model.view(), request, out);
        int n_hits = 0;
        for (int y = 0; y < kRows; ++y) {
            const double h = (kRows / 2 - y) * kStep;  // of the ray over the tangent plane
            const std::size_t i = out.index(8, y);
            if (std::abs(h) > kReach * kReach / 2) {
                ASSERT_EQ(out.hit[i], h < 0) << degree << ' ' << h;
            }
            if (!out.hit[i]) continue;
            ++n_hits;
            EXPECT_NEAR(out.position[0][i], std::sqrt(std::max(0.0, -2 * h)), kReach)
                << degree << ' ' << h;
        }
        EXPECT_GT(n_hits, kRows / 2 - 5) << degree;
    }
}

TEST(ExtremeViews, Row37AnEyeInsideABallAndBallsAcrossTheNearPlane) {
    const auto model = test::sphere_model(1, 400);
    // Inside a ball, within it of the surface; and grazing along the surface.
    for (const Vec3d eye : {Vec3d{0, 0, 1.02}, Vec3d{0, 0, 0.97}, Vec3d{0, 0.05, 1.005}})
        for (const Vec3d target : {Vec3d{0, 0, 0}, Vec3d{1, 0, 1}, Vec3d{0, 0.3, 2}}) {
            RenderRequest request = request_at(eye, target, 90, 120, 90);
            for (const double near_plane : {0.0, 0.05}) {
                request.camera.near_plane = near_plane;
                const Difference d = against_brute(model, request);
                EXPECT_LE(d.hits, 2u) << eye.z << ' ' << target.x << ' ' << near_plane;
                EXPECT_LT(d.depth, 1e-3) << eye.z << ' ' << target.x << ' ' << near_plane;
            }
        }
}

TEST(ExtremeViews, Row38FromAMillionDiagonalsFloatsAreAsGoodAsDoubles) {
    // Paraboloids of radius 0.155 lie within 1e-4 of the sphere, their normals within 2e-3,
    // near and far.
    constexpr double kOffSphere = 1e-4, kOffNormal = 2e-3;
    const auto model = test::sphere_model(1, 1000);
    const double far = 1e6 * model.header.diagonal;
    const double fov = 2 * std::atan(1.1 / far) * 180 / std::numbers::pi;
    const RenderRequest request =
        request_at(Vec3d{0.3, 0.4, std::sqrt(0.75)} * far, {}, fov, 160, 160);
    const PixelView view = pixel_view(request.camera, 160, 160);
    GBuffer fast, slow;
    render_forward(model.view(), request, fast);
    render_brute(model.view(), request, slow);
    std::size_t covered = 0, other_hits = 0, other_places = 0, other_normals = 0;
    for (int y = 0; y < 160; ++y)
        for (int x = 0; x < 160; ++x) {
            const std::size_t i = fast.index(x, y);
            other_hits += fast.hit[i] != slow.hit[i];
            if (!fast.hit[i] || !slow.hit[i]) continue;
            ++covered;
            const auto at = [&](const std::array<std::vector<float>, 3>& plane) {
                return Vec3d{plane[0][i], plane[1][i], plane[2][i]};
            };
            const Vec3d p = at(fast.position), n = at(fast.normal);
            other_places += length(p - at(slow.position)) > 2e-6;
            other_normals += length(n - at(slow.normal)) > 2e-5;
            // The truth: on the sphere, on the pixel's own ray, its normal.
            EXPECT_NEAR(length(p), 1, kOffSphere) << x << ' ' << y;
            EXPECT_LT(length(n - normalized(p)), kOffNormal) << x << ' ' << y;
            const Vec3d c = view.camera_from_local(p);
            EXPECT_NEAR(c.x / c.z * view.focal_px + view.center_x, x + 0.5, 1e-3);
            EXPECT_NEAR(c.y / c.z * view.focal_px + view.center_y, y + 0.5, 1e-3);
            // A float of 3.5e6 has steps of 0.25.
            EXPECT_LE(std::abs(static_cast<double>(fast.depth[i]) - c.z), 0.13);
        }
    EXPECT_GT(covered, 15000u);
    EXPECT_LE(other_hits, 2u);
    EXPECT_LE(other_places, 3u);   // at the rim a rounding moves the root
    EXPECT_LE(other_normals, 3u);
}

// Grazing rays at the rim of a sphere of 0.3 of the depth: the square root of the rounding.
constexpr double kSameDepth = 1e-3;

TEST(ExtremeViews, Row39AnyAngleOfViewAndOrthographic) {
    const auto model = test::sphere_model(1, 600);
    for (const double fov : {0.001, 1.0, 120.0, 175.0, 179.0}) {
        const double distance =
            fov < 90 ? std::max(3.0, 1.2 / std::tan(fov * std::numbers::pi / 360)) : 1.3;
        const Difference d = against_brute(model, request_at({0, 0, distance}, {}, fov, 121, 121));
        EXPECT_GT(d.covered, 0u) << fov;
        EXPECT_LE(d.hits, 2u) << fov;
        EXPECT_LT(d.depth, kSameDepth) << fov;
    }
    RenderRequest parallel = request_at({0, 0, 3}, {}, 35, 120, 120);
    parallel.camera.orthographic = true;
    parallel.camera.width = 2.5;
    const Difference d = against_brute(model, parallel);
    EXPECT_GT(d.covered, 5000u);
    EXPECT_LE(d.hits, 2u);
    EXPECT_LT(d.depth, kSameDepth);
}

// Surfels whose middles lie farther off the picture than ints count pixels.
TEST(ExtremeViews, PicturesMuchNarrowerThanASurfel) {
    const auto model = test::sphere_model(1, 600);
    RenderRequest request = request_at({0.3, 0.2, 3}, {0.3, 0.2, 0}, 35, 120, 90);
    request.camera.orthographic = true;
    for (const double width : {1e-3, 1e-6, 1e-9, 1e-12, 1e-30, 1e-90}) {
        request.camera.width = width;
        const Difference d = against_brute(model, request);
        EXPECT_EQ(d.covered, 120u * 90u) << width;
        EXPECT_EQ(d.hits, 0u) << width;
        EXPECT_LT(d.depth, 1e-6) << width;
    }
    for (const double width : {1e-200, 1e-310}) {
        request.camera.width = width;
        GBuffer out;
        EXPECT_THROW(render_forward(model.view(), request, out), ConfigError) << width;
    }
    for (const double above : {1e-6, 1e-9}) {
        const Difference d =
            against_brute(model, request_at({0, 0, 1 + above}, {0, 0, 1}, 1e-3, 60, 60));
        EXPECT_LE(d.hits, 2u) << above;
    }
}

/// A picture against the crop in the middle of a larger one of the same pixels: sides grow by an
/// even number. (Bytes may differ: tiles begin elsewhere.)
void expect_middle_of(const SurfelTreeData& model, const RenderRequest& small, int width,
                      int height) {
    RenderRequest large = small;
    large.width = width, large.height = height;
    const double half =
        std::tan(small.camera.fov_y_deg * std::numbers::pi / 360) * height / small.height;
    large.camera.fov_y_deg = std::atan(half) * 360 / std::numbers::pi;
    GBuffer alone, whole;
    const auto n_alone = render_forward(model.view(), small, alone).covered_pixels;
    EXPECT_GT(render_forward(model.view(), large, whole).covered_pixels, n_alone);
    const int left = (width - small.width) / 2, top = (height - small.height) / 2;
    std::size_t n = 0;
    for (int y = 0; y < small.height; ++y)
        for (int x = 0; x < small.width; ++x) {
            const std::size_t i = alone.index(x, y), j = whole.index(left + x, top + y);
            ASSERT_EQ(alone.hit[i], whole.hit[j]) << x << ' ' << y;
            n += alone.hit[i];
            EXPECT_NEAR(alone.depth[i], whole.depth[j], 1e-6f * whole.depth[j]) << x << ' ' << y;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                EXPECT_NEAR(alone.normal[axis][i], whole.normal[axis][j], 2e-5f) << x << ' ' << y;
                EXPECT_NEAR(alone.position[axis][i], whole.position[axis][j], 2e-6f)
                    << x << ' ' << y;
            }
        }
    EXPECT_EQ(n, n_alone);
}

TEST(ExtremeViews, Row40TinyPicturesAreCropsOfLargerOnes) {
    const auto model = test::sphere_model(1, 600);
    // The sphere takes up 28 degrees from there: 93 of 97 rows of 30,
    // 15 of 131 pixels in a row of 2.
    const RenderRequest pixel = request_at({0, 0, 4}, {}, 2, 1, 1),
                        column = request_at({0, 0, 4}, {}, 30, 1, 97),
                        row = request_at({0, 0, 4}, {}, 2, 131, 1);
    for (const auto& [request, covered] :
         {std::pair{pixel, 1u}, std::pair{column, 93u}, std::pair{row, 15u}}) {
        const Difference d = against_brute(model, request);
        EXPECT_NEAR(static_cast<double>(d.covered), covered, 1.5);
        EXPECT_EQ(d.hits, 0u);
    }
    expect_middle_of(model, pixel, 31, 27);
    expect_middle_of(model, column, 133, 97);
    expect_middle_of(model, column, 65, 121);
    expect_middle_of(model, row, 131, 41);
    expect_middle_of(model, row, 157, 33);
}

TEST(ExtremeViews, Row40WindowsOfHugePicturesAgree) {
    const auto model = test::sphere_model(1, 600);
    // Of 16,384 x 16,384 pixels only a window is ever held; two that overlap agree byte for byte.
    RenderRequest request = request_at({0, 0, 4}, {}, 30, 16384, 16384);
    GBuffer wide, narrow;
    request.window = {9000, 7000, 400, 120};
    render_forward(model.view(), request, wide);
    EXPECT_EQ(wide.n_pixels(), 400u * 120u);
    request.window = {9131, 7040, 77, 50};
    const RenderStats stats = render_forward(model.view(), request, narrow);
    EXPECT_EQ(stats.covered_pixels, 77u * 50u);
    for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 77; ++x) {
            const std::size_t i = narrow.index(x, y), j = wide.index(131 + x, 40 + y);
            ASSERT_EQ(narrow.depth[i], wide.depth[j]) << x << ' ' << y;
            ASSERT_EQ(narrow.normal[0][i], wide.normal[0][j]) << x << ' ' << y;
        }
}

TEST(ExtremeViews, Row41EyeAtTheTargetOrUpAlongTheViewIsRefused) {
    const auto model = test::sphere_model(1, 200);
    GBuffer out;
    RenderRequest request = request_at({1, 2, 3}, {1, 2, 3}, 30, 10, 10);
    EXPECT_THROW(render_forward(model.view(), request, out), ConfigError);
    request.camera.target = {1, 2, 0};
    request.camera.up = {0, 0, -4};
    EXPECT_THROW(render_forward(model.view(), request, out), ConfigError);
}

/// Whether all pixels within `reach` are on the same side of the silhouette as (x, y).
bool is_far_from_silhouette(const GBuffer& b, int x, int y, int reach) {
    for (int v = std::max(0, y - reach); v <= std::min(b.height - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(b.width - 1, x + reach); ++u)
            if (b.hit[b.index(u, v)] != b.hit[b.index(x, y)]) return false;
    return true;
}

TEST(ExtremeViews, Row42LevelOfDetailMovesTheSilhouetteByTwoPixelsAtMost) {
    const auto model = test::two_level_sphere(1, 1500, 12000);
    RenderRequest request = request_at({0, 0, 30}, {}, 20, 160, 160);
    GBuffer full, coarse;
    const auto all = render_forward(model.view(), request, full);
    request.lod_px = 4;
    const auto cut = render_forward(model.view(), request, coarse);
    ASSERT_LT(cut.surfels_drawn, all.surfels_drawn / 2);
    int n_moved = 0;
    for (int y = 0; y < 160; ++y)
        for (int x = 0; x < 160; ++x) {
            if (full.hit[full.index(x, y)] == coarse.hit[coarse.index(x, y)]) continue;
            ++n_moved;
            EXPECT_FALSE(is_far_from_silhouette(full, x, y, 2)) << x << ' ' << y;
        }
    EXPECT_LT(n_moved, 40);
}

TEST(ExtremeViews, Row43UmbilicAndFlatSurfacesHaveNoCrestLines) {
    const auto sphere = test::sphere_model(1, 1500, 3);
    std::vector<Surfel> discs;
    for (int i = 0; i < 100; ++i)
        discs.push_back({{0.2 * (i % 10) - 0.9, 0.2 * (i / 10) - 0.9, 0},
                         0.35,
                         frame_from_normal(Vec3d{0, 0, 1}),
                         {},
                         3});
    const auto plane = test::flat_tree(discs, 3);
    const std::vector<LineKind> kinds{LineKind::valley, LineKind::ridge};
    for (const SurfelTreeData* model : {&sphere, &plane}) {
        RenderRequest request = request_at({0, 0, 5}, {}, 30, 200, 200);
        request.wanted = kAllChannels;
        GBuffer out;
        ASSERT_GT(render_forward(model->view(), request, out).covered_pixels, 5000u);
        const PixelView view = pixel_view(request.camera, 200, 200);
        EXPECT_TRUE(extract_lines({out, view, model->header.diagonal, 3}, kinds).empty());
    }
}

}  // namespace
}  // namespace slim
