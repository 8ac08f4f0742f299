#include "raytrace/project/pixel_records.h"

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/block_spans.h"
#include "raytrace/project/outline.h"
#include "slim/base/hash.h"
#include "slim/blend/ray_surfel.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

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
    Vec3d local, gradient;
    std::array<double, 6> hessian;  ///< of f rho, over 1 / rho, camera axes

    Direct(const PixelView& view, const Surfel& s, int x, int y, double z) {
        const Vec3d q = (view.point_at(x + 0.5, y + 0.5, z) - s.center) / s.support_radius;
        local = s.frame.local_from_world(q);
        f = local.z - s.polynomial.value(local.x, local.y);
        sq_distance = sq_length(q);
        gradient = view.rotate_to_camera(world_gradient(s, local.x, local.y));
        const Vec3d u = view.rotate_to_camera(s.frame.u_axis), v = view.rotate_to_camera(s.frame.v_axis);
        const double uu = s.polynomial.d_uu(local.x, local.y), uv = s.polynomial.d_uv(local.x, local.y),
                     vv = s.polynomial.d_vv(local.x, local.y);
        std::size_t at = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = i; j < 3; ++j)
                hessian[at++] = -(uu * u[i] * u[j] + uv * (u[i] * v[j] + v[i] * u[j]) + vv * v[i] * v[j]);
    }
};

/// A surfel as a batch of its own: all lanes repeat it.
SurfelLanes lanes_of(const PixelView& view, const Surfel& s) {
    SurfelBatch batch;
    batch.add(view.camera_from_local(s.center), s);
    return batch.lanes(view);
}

/// Its record, from the last lane.
template <int Degree>
PixelRecord<Degree> record_of(const PixelView& view, const Surfel& s) {
    PixelRecord<Degree> r;
    std::array<PixelRecord<Degree>*, kSurfelLanes> out{};
    out.back() = &r;
    const SurfelLanes lanes = lanes_of(view, s);
    fill_pixel_records(lanes, ray_form(view, lanes), out);
    return r;
}

template <int Degree>
void expect_direct_values(bool orthographic, double nearest) {
    const PixelView view = view_of(orthographic);
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(testing::Message() << Degree << ' ' << orthographic << ' ' << nearest << ' ' << seed);
        const Surfel s = random_surfel(seed, Degree, nearest);
        const auto r = record_of<Degree>(view, s);
        const Vec3d c = view.camera_from_local(s.center);
        const double scale = orthographic ? view.px_per_unit : view.focal_px / c.z;
        const int x = static_cast<int>(view.center_x + scale * (c.x + 0.5 * s.support_radius * uniform(seed, 30)));
        const int y = static_cast<int>(view.center_y + scale * (c.y + 0.5 * s.support_radius * uniform(seed, 31)));
        const double z = c.z + s.support_radius * 0.7 * uniform(seed, 32);
        const double height = orthographic ? 1 : c.z / z;
        const OneLane tau(static_cast<float>((z - c.z) / s.support_radius * height));
        const auto offset = [&](int pixel, float first, float base) {
            return OneLane(base + (static_cast<float>(pixel) - first) * r.step);
        };
        const OneLane at = offset(x, r.pixel_x, r.base_x);
        const float sq_radius = 0.6f;
        const RowOf<Degree, OneLane> row(r, offset(y, r.pixel_y, r.base_y), sq_radius);
        const OneLane share = row.share(tau);
        const Direct direct(view, s, x, y, z);
        constexpr double tolerance = 4e-6;
        ASSERT_NEAR(share[0], 1 / height, tolerance);
        ASSERT_NEAR(lanes_value(row.polynomial(at), tau)[0], direct.f * std::pow(height, Degree), tolerance);
        ASSERT_NEAR(row.ball(at).value(tau)[0], (direct.sq_distance - sq_radius) * height * height, tolerance);
        const auto plane = row.plane(at, tau, share);
        ASSERT_NEAR(plane.u[0], direct.local.x, tolerance);
        ASSERT_NEAR(plane.v[0], direct.local.y, tolerance);
        for (std::size_t k = 0; k < 6; ++k)
            ASSERT_NEAR(row.hessian(k, plane)[0] * r.radius, direct.hessian[k], tolerance) << k;
        const auto g = row.gradient(at, tau, share);
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

struct Outlined {
    Outline outline;
    ScreenRect rect;
};
Outlined outlined(const PixelView& view, const Surfel& s) {
    const SurfelLanes lanes = lanes_of(view, s);
    const OutlinedRects rects({0, 0, 200, 200}, ray_form(view, lanes), lanes, patch_bounds(lanes, 1));
    return {rects.outline(kSurfelLanes - 1), rects.rect(kSurfelLanes - 1)};
}

bool holds(const ScreenRect& r, int x, int y) { return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1; }

TEST(PixelRecord, EveryLaneIsItsOwnSurfel) {
    const PixelView view = view_of(false);
    SurfelBatch batch;
    std::vector<Surfel> surfels;
    while (!batch.full()) {
        surfels.push_back(random_surfel(surfels.size(), 3, 1));
        batch.add(view.camera_from_local(surfels.back().center), surfels.back());
    }
    const SurfelLanes lanes = batch.lanes(view);
    std::vector<PixelRecord<3>> records(kSurfelLanes);
    std::array<PixelRecord<3>*, kSurfelLanes> out{};
    for (std::size_t k = 0; k < kSurfelLanes; ++k) out[k] = &records[k];
    fill_pixel_records(lanes, ray_form(view, lanes), out);
    const OutlinedRects rects({0, 0, 200, 200}, ray_form(view, lanes), lanes, patch_bounds(lanes, 1));
    for (std::size_t k = 0; k < kSurfelLanes; ++k) {
        const auto alone = record_of<3>(view, surfels[k]);
        EXPECT_EQ(records[k].base_x, alone.base_x);
        EXPECT_EQ(records[k].f, alone.f);
        EXPECT_EQ(records[k].v_axis, alone.v_axis);
        EXPECT_EQ(records[k].hessian, alone.hessian);
        EXPECT_EQ(records[k].a, alone.a);
        EXPECT_EQ(rects.rect(k).x0, outlined(view, surfels[k]).rect.x0);
        EXPECT_EQ(rects.outline(k).c2, outlined(view, surfels[k]).outline.c2);
    }
}

TEST(Outline, RectHoldsEveryPixelOfTheSurfaceAndLessThanTheBall) {
    double in_patch = 0, in_ball = 0;
    for (const bool orthographic : {false, true})
        for (const int degree : {1, 2, 3})
            for (std::uint64_t seed = 0; seed < 60; ++seed) {
                SCOPED_TRACE(testing::Message() << orthographic << ' ' << degree << ' ' << seed);
                const PixelView view = view_of(orthographic);
                const Surfel s = random_surfel(seed, degree, seed % 3 ? 0.7 : 2);
                const ScreenRect r = outlined(view, s).rect;
                const ScreenRect ball =
                    screen_rect(view, {0, 0, 200, 200}, view.camera_from_local(s.center), s.support_radius);
                in_patch += (r.x1 - r.x0) * (r.y1 - r.y0), in_ball += (ball.x1 - ball.x0) * (ball.y1 - ball.y0);
                for (int y = ball.y0; y < ball.y1; ++y)
                    for (int x = ball.x0; x < ball.x1; ++x)
                        if (!holds(r, x, y)) { ASSERT_FALSE(meets_patch(view, s, x, y)) << x << ' ' << y; }
            }
    EXPECT_LT(in_patch, 0.97 * in_ball);  // these are as thick as any: cubics of slope 1
}

TEST(Outline, HoldsALevelPlaneBesideItsCentreSeenEdgeOn) {
    // Such a patch lies wholly on one side of its centre's ray.
    const PixelView view = view_of(false);
    for (const double offset : {-0.3, -0.1, 0.1, 0.3})
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(testing::Message() << offset << ' ' << seed);
            Surfel s = random_surfel(seed, 1, 1);
            // Across the centre's ray and a little towards it, so that pixels meet the plane.
            const Vec3d ray = normalized(s.center);
            const Vec3d across = normalized(cross(ray, s.frame.normal));
            s.frame = frame_from_normal(normalized(across + ray * 0.02));
            s.polynomial = {};
            s.polynomial.a[0] = offset;
            const ScreenRect r = outlined(view, s).rect;
            for (int y = 0; y < 200; ++y)
                for (int x = 0; x < 200; ++x)
                    if (!holds(r, x, y)) { ASSERT_FALSE(meets_patch(view, s, x, y)) << x << ' ' << y; }
        }
}

/// Blocks of the tile about a surfel that its outline is said to touch.
std::array<bool, kTileBlocks> listed_blocks(const PixelView& view, const Surfel& s, TileBuffers& t) {
    const auto r = record_of<2>(view, s);
    t.x0 = static_cast<int>(r.pixel_x) - 16, t.y0 = static_cast<int>(r.pixel_y) - 16;
    t.clip = {t.x0, t.y0, t.x0 + kTileSize, t.y0 + kTileSize};
    const Outlined full = outlined(view, s);
    std::array<bool, kTileBlocks> listed{};
    if (t.on_tile(full.rect).empty()) return listed;
    const BlockMask blocks = BlockSpans(full.outline, TileGrid(r, t), t.on_tile(full.rect)).blocks();
    for (int k = 0; k < kTileBlocks; ++k) listed[static_cast<std::size_t>(k)] = blocks.has(k);
    return listed;
}

TEST(BlockSpans, HoldEveryPixelOfTheSurfaceAndAreTight) {
    int in_list = 0, met = 0;
    auto t = std::make_unique<TileBuffers>();
    for (const bool orthographic : {false, true})
        for (std::uint64_t seed = 0; seed < 80; ++seed) {
            SCOPED_TRACE(testing::Message() << orthographic << ' ' << seed);
            const PixelView view = view_of(orthographic);
            Surfel s = random_surfel(seed, 2, 1);
            for (double& a : s.polynomial.a) a *= 0.1;  // as thin as fits are
            const auto listed = listed_blocks(view, s, *t);
            std::array<bool, kTileBlocks> touched{};
            for (int y = 0; y < kTileSize; ++y)
                for (int x = 0; x < kTileSize; ++x) {
                    if (t->x0 + x < 0 || t->y0 + y < 0 || t->x0 + x >= 200 || t->y0 + y >= 200) continue;
                    if (!meets_patch(view, s, t->x0 + x, t->y0 + y)) continue;
                    const std::size_t block = pixel_entry(x, y) / kLanes;
                    touched[block] = true;
                    ASSERT_TRUE(listed[block]) << x << ' ' << y;
                }
            for (const bool b : listed) in_list += b;
            for (const bool b : touched) met += b;
        }
    EXPECT_GT(met, 1000);
    EXPECT_LT(in_list, 1.25 * met);
}

}  // namespace
}  // namespace slim
