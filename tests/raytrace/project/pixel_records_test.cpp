#include "raytrace/project/pixel_records.h"

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/row_spans.h"
#include "raytrace/project/screen_rect.h"
#include "slim/base/hash.h"
#include "slim/blend/ray_surfel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

using OneLane = stdx::simd<float, stdx::simd_abi::scalar>;

double uniform(std::uint64_t seed, std::uint64_t i) { return 2 * unit_interval(keyed_hash(seed, i)) - 1; }

/// In front of a camera at the origin that looks along z.
Surfel random_surfel(std::uint64_t seed, int degree, double nearest) {
    Surfel s{};
    const double z = nearest + 1 + uniform(seed, 0);
    s.center = {0.5 * z * uniform(seed, 1), 0.5 * z * uniform(seed, 2), z};
    s.support_radius = 0.1 + 0.05 * uniform(seed, 3);
    s.frame = frame_from_normal(normalized(Vec3d{uniform(seed, 4), uniform(seed, 5), uniform(seed, 6)}));
    const auto n = static_cast<std::uint64_t>(degree <= 1 ? 1 : n_coefficients(degree));
    for (std::uint64_t k = 0; k < n; ++k) s.polynomial.a[k] = (k < 3 ? 0.1 : 0.3) * uniform(seed, 10 + k);
    s.degree = degree;
    return s;
}

PixelView view_of(bool orthographic) {
    Camera camera;
    camera.eye = {0, 0, 0}, camera.target = {0, 0, 1}, camera.up = {0, -1, 0};
    camera.orthographic = orthographic, camera.fov_y_deg = 70, camera.width = 3;
    return pixel_view(camera, 200, 200);
}

/// f, |q|^2 and the gradient at a pixel's ray and a depth, straight from the surfel.
struct Direct {
    double f, sq_distance;
    Vec3d gradient;

    Direct(const PixelView& view, const Surfel& s, int x, int y, double z) {
        const Vec3d q = (view.point_at(x + 0.5, y + 0.5, z) - s.center) / s.support_radius;
        const Vec3d local = s.frame.local_from_world(q);
        f = local.z - s.polynomial.value(local.x, local.y);
        sq_distance = sq_length(q);
        gradient = view.rotate_to_camera(world_gradient(s, local.x, local.y));
    }
};

template <int Degree>
void expect_direct_values(bool orthographic, double nearest) {
    const PixelView view = view_of(orthographic);
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(testing::Message() << Degree << ' ' << orthographic << ' ' << nearest << ' ' << seed);
        const Surfel s = random_surfel(seed, Degree, nearest);
        PixelRecord<Degree> r;
        fill_pixel_record(view, s, r);
        const Vec3d c = view.camera_from_local(s.center);
        const double scale = orthographic ? view.px_per_unit : view.focal_px / c.z;
        const int x = static_cast<int>(view.center_x + scale * (c.x + 0.5 * s.support_radius * uniform(seed, 30)));
        const int y = static_cast<int>(view.center_y + scale * (c.y + 0.5 * s.support_radius * uniform(seed, 31)));
        const double z = c.z + s.support_radius * 0.7 * uniform(seed, 32);
        const OneLane tau(static_cast<float>((z - c.z) / s.support_radius));
        const RowOf<Degree> row(r, static_cast<float>(y));
        const auto offset = pixel_offset<Degree, OneLane>(r, OneLane(static_cast<float>(x)));
        const Direct direct(view, s, x, y, z);
        constexpr double tolerance = 4e-6;
        ASSERT_NEAR(lanes_value(pixel_polynomial<Degree, OneLane>(r, row, offset), tau)[0], direct.f, tolerance);
        ASSERT_NEAR((ball_lanes<Degree, OneLane>(r, row, offset).sq_distance(tau)[0]), direct.sq_distance, tolerance);
        const auto g = pixel_gradient<Degree, OneLane>(r, row, offset, tau);
        ASSERT_NEAR(g.x[0], direct.gradient.x, tolerance);
        ASSERT_NEAR(g.y[0], direct.gradient.y, tolerance);
        ASSERT_NEAR(g.z[0], direct.gradient.z, tolerance);
    }
}

TEST(PixelRecord, IsTheSurfelAsAFunctionOfThePixel) {
    for (const bool orthographic : {false, true})
        for (const double nearest : {0.7, 1.0, 10.0}) {
            expect_direct_values<1>(orthographic, nearest);
            expect_direct_values<2>(orthographic, nearest);
            expect_direct_values<3>(orthographic, nearest);
        }
}

/// Whether the ray of a pixel meets the surface inside its ball.
bool meets_patch(const PixelView& view, const Surfel& s, int x, int y) {
    const LocalRay local = local_ray({view.ray_origin(x + 0.5, y + 0.5), view.ray_direction(x + 0.5, y + 0.5)}, s);
    if (!local.meets_ball()) return false;
    const double half = local.half_chord();
    return ray_roots(ray_polynomial(local, s.polynomial), -half, half).n > 0;
}

TEST(PatchBounds, HoldEveryPixelOfTheSurfaceAndLessThanTheBall) {
    double in_patch = 0, in_ball = 0;
    for (const bool orthographic : {false, true})
        for (const int degree : {1, 2, 3})
            for (std::uint64_t seed = 0; seed < 60; ++seed) {
                SCOPED_TRACE(testing::Message() << orthographic << ' ' << degree << ' ' << seed);
                const PixelView view = view_of(orthographic);
                const Surfel s = random_surfel(seed, degree, seed % 3 ? 0.3 : 2);
                const Vec3d c = view.camera_from_local(s.center);
                const PatchView from(view, c, view.rotate_to_camera(s.frame.normal));
                const PixelWindow window{0, 0, 200, 200};
                const ScreenRect r =
                    screen_rect(from, window, patch_bounds(s.support_radius, 1, s.polynomial));
                const ScreenRect ball = screen_rect(view, window, c, s.support_radius);
                in_patch += (r.x1 - r.x0) * (r.y1 - r.y0), in_ball += (ball.x1 - ball.x0) * (ball.y1 - ball.y0);
                for (int y = ball.y0; y < ball.y1; ++y)
                    for (int x = ball.x0; x < ball.x1; ++x)
                        if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1) {
                            ASSERT_FALSE(meets_patch(view, s, x, y)) << x << ' ' << y;
                        }
            }
    EXPECT_LT(in_patch, 0.95 * in_ball);  // these are as thick as any: cubics of slope 1
}

TEST(PatchBounds, HoldALevelPlaneBesideItsCentreSeenEdgeOn) {
    // Such a patch lies wholly on one side of its centre's ray.
    const PixelView view = view_of(false);
    for (const double offset : {-0.3, -0.1, 0.1, 0.3})
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(testing::Message() << offset << ' ' << seed);
            Surfel s = random_surfel(seed, 1, 1);
            const Vec3d c = view.camera_from_local(s.center);
            // Across the centre's ray and a little towards it, so that pixels meet the plane.
            const Vec3d ray = normalized(s.center);
            const Vec3d across = normalized(cross(ray, s.frame.normal));
            s.frame = frame_from_normal(normalized(across + ray * 0.02));
            s.polynomial = {};
            s.polynomial.a[0] = offset;
            const PatchView from(view, c, view.rotate_to_camera(s.frame.normal));
            const ScreenRect r = screen_rect(from, {0, 0, 200, 200}, patch_bounds(s.support_radius, 1, s.polynomial));
            for (int y = 0; y < 200; ++y)
                for (int x = 0; x < 200; ++x)
                    if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1) {
                        ASSERT_FALSE(meets_patch(view, s, x, y)) << x << ' ' << y;
                    }
        }
}

TEST(RowSpans, HoldEveryPixelOfTheBallAndAreTight) {
    std::int64_t in_spans = 0, met = 0;
    for (const bool orthographic : {false, true})
        for (std::uint64_t seed = 0; seed < 60; ++seed) {
            SCOPED_TRACE(testing::Message() << orthographic << ' ' << seed);
            const PixelView view = view_of(orthographic);
            const Surfel s = random_surfel(seed, 2, 1);
            PixelRecord<2> r;
            fill_pixel_record(view, s, r);
            TileBuffers t;
            t.x0 = static_cast<int>(r.pixel_x) - 16, t.y0 = static_cast<int>(r.pixel_y) - 16;
            const RowSpans spans = row_spans(r, 1, t, 0, kTileSize);
            for (int y = 0; y < kTileSize; ++y) {
                in_spans += spans.x1[y] - spans.x0[y];
                for (int x = 0; x < kTileSize; ++x) {
                    const double px = t.x0 + x + 0.5, py = t.y0 + y + 0.5;
                    if (!local_ray({view.ray_origin(px, py), view.ray_direction(px, py)}, s).meets_ball()) continue;
                    ++met;
                    ASSERT_TRUE(x >= spans.x0[y] && x < spans.x1[y]) << x << ' ' << y;
                }
            }
        }
    EXPECT_LT(in_spans, met + 120 * 2 * kTileSize);
}

}  // namespace
}  // namespace slim
