#include "raytrace/project/pixel_records.h"

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/block_spans.h"
#include "raytrace/project/outline.h"
#include "slim/base/hash.h"
#include "slim/blend/ray_surfel.h"
#include "slim/model/surfel_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

using OneLane = stdx::simd<float, stdx::simd_abi::scalar>;

double uniform(std::uint64_t seed, std::uint64_t i) {
    return 2 * unit_interval(keyed_hash(seed, i)) - 1;
}

/// In front of a camera at the origin that looks along z.
Surfel random_surfel(std::uint64_t seed, int degree, double nearest) {
    Surfel s{};
    const double z = nearest + 1 + uniform(seed, 0);
    s.center = {0.5 * z * uniform(seed, 1), 0.5 * z * uniform(seed, 2), z};
    s.support_radius = 0.1 + 0.05 * uniform(seed, 3);
    s.frame = frame_from_normal(
        round_normal(normalized(Vec3d{uniform(seed, 4), uniform(seed, 5), uniform(seed, 6)})));
    const auto n = static_cast<std::uint64_t>(degree <= 1 ? 1 : n_coefficients(degree));
    for (std::uint64_t k = 0; k < n; ++k)
        s.polynomial.a[k] = (k < 3 ? 0.1 : 0.3) * uniform(seed, 10 + k);
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
        const Vec3d u = view.rotate_to_camera(s.frame.u_axis),
                    v = view.rotate_to_camera(s.frame.v_axis);
        const double uu = s.polynomial.d_uu(local.x, local.y),
                     uv = s.polynomial.d_uv(local.x, local.y),
                     vv = s.polynomial.d_vv(local.x, local.y);
        std::size_t at = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = i; j < 3; ++j)
                hessian[at++] =
                    -(uu * u[i] * u[j] + uv * (u[i] * v[j] + v[i] * u[j]) + vv * v[i] * v[j]);
    }
};

void add(const PixelView& view, const Surfel& s, SurfelBatch& batch) {
    batch.add(view.camera_from_local(s.center), s.support_radius,
              octahedral_from_normal(s.frame.normal),
              std::span<const double, kMaxCoefficients>(s.polynomial.a));
}

/// A surfel as a batch of its own: all lanes repeat it.
SurfelLanes lanes_of(const PixelView& view, const Surfel& s) {
    SurfelBatch batch;
    add(view, s, batch);
    return batch.lanes(view);
}

/// Its record, from the last lane.
template <int Degree>
PixelRecord<Degree> record_of(const PixelView& view, const Surfel& s) {
    PixelRecord<Degree> r;
    std::array<PixelRecord<Degree>*, kSurfelLanes> out{};
    out.back() = &r;
    const SurfelLanes lanes = lanes_of(view, s);
    const RayForm form = ray_form(view, lanes);
    fill_pixel_records(lanes, form, PixelGrid(form), out);
    return r;
}

template <int Degree>
void expect_direct_values(bool orthographic, double nearest) {
    const PixelView view = view_of(orthographic);
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(testing::Message()
                     << Degree << ' ' << orthographic << ' ' << nearest << ' ' << seed);
        const Surfel s = random_surfel(seed, Degree, nearest);
        const auto r = record_of<Degree>(view, s);
        const Vec3d c = view.camera_from_local(s.center);
        const double scale = orthographic ? view.px_per_unit : view.focal_px / c.z;
        const int x = static_cast<int>(view.center_x +
                                       scale * (c.x + 0.5 * s.support_radius * uniform(seed, 30)));
        const int y = static_cast<int>(view.center_y +
                                       scale * (c.y + 0.5 * s.support_radius * uniform(seed, 31)));
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
        ASSERT_NEAR(lanes_value(row.polynomial(at), tau)[0], direct.f * std::pow(height, Degree),
                    tolerance);
        ASSERT_NEAR(row.ball(at).value(tau)[0], (direct.sq_distance - sq_radius) * height * height,
                    tolerance);
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
    const LocalRay local =
        local_ray({view.ray_origin(x + 0.5, y + 0.5), view.ray_direction(x + 0.5, y + 0.5)}, s);
    if (!local.meets_ball()) return false;
    const double half = local.half_chord();
    return ray_roots(ray_polynomial(local, s.polynomial), -half, half).n > 0;
}

/// The footprints of some patches in a window of 200 x 200.
std::array<Footprint, kSurfelLanes> footprints(const PixelView& view, const SurfelLanes& lanes) {
    std::array<Footprint, kSurfelLanes> out;
    std::array<Footprint*, kSurfelLanes> to;
    for (std::size_t k = 0; k < kSurfelLanes; ++k) to[k] = &out[k];
    const RayForm form = ray_form(view, lanes);
    Footprints({0, 0, 200, 200}, form, PixelGrid(form), lanes, patch_bounds(lanes, 1)).put(to);
    return out;
}

Footprint footprint(const PixelView& view, const Surfel& s) {
    return footprints(view, lanes_of(view, s)).back();
}

bool holds(const ScreenRect& r, int x, int y) {
    return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
}

TEST(PixelRecord, EveryLaneIsItsOwnSurfel) {
    const PixelView view = view_of(false);
    SurfelBatch batch;
    std::vector<Surfel> surfels;
    while (!batch.full()) {
        surfels.push_back(random_surfel(surfels.size(), 3, 1));
        add(view, surfels.back(), batch);
    }
    const SurfelLanes lanes = batch.lanes(view);
    std::vector<PixelRecord<3>> records(kSurfelLanes);
    std::array<PixelRecord<3>*, kSurfelLanes> out{};
    for (std::size_t k = 0; k < kSurfelLanes; ++k) out[k] = &records[k];
    const RayForm form = ray_form(view, lanes);
    fill_pixel_records(lanes, form, PixelGrid(form), out);
    const auto feet = footprints(view, lanes);
    for (std::size_t k = 0; k < kSurfelLanes; ++k) {
        const auto alone = record_of<3>(view, surfels[k]);
        EXPECT_EQ(records[k].base_x, alone.base_x);
        EXPECT_EQ(records[k].f, alone.f);
        EXPECT_EQ(records[k].v_axis, alone.v_axis);
        EXPECT_EQ(records[k].hessian, alone.hessian);
        EXPECT_EQ(records[k].a, alone.a);
        const Footprint foot = footprint(view, surfels[k]);
        EXPECT_EQ(feet[k].rect.x0, foot.rect.x0);
        EXPECT_EQ(feet[k].outline.c2, foot.outline.c2);
        EXPECT_EQ(feet[k].pixel_x, records[k].pixel_x);
        EXPECT_EQ(feet[k].step, records[k].step);
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
                const ScreenRect r = footprint(view, s).rect;
                const ScreenRect ball = screen_rect(
                    view, {0, 0, 200, 200}, view.camera_from_local(s.center), s.support_radius);
                in_patch += (r.x1 - r.x0) * (r.y1 - r.y0),
                    in_ball += (ball.x1 - ball.x0) * (ball.y1 - ball.y0);
                for (int y = ball.y0; y < ball.y1; ++y)
                    for (int x = ball.x0; x < ball.x1; ++x)
                        if (!holds(r, x, y)) {
                            ASSERT_FALSE(meets_patch(view, s, x, y)) << x << ' ' << y;
                        }
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
            s.frame = frame_from_normal(round_normal(normalized(across + ray * 0.02)));
            s.polynomial = {};
            s.polynomial.a[0] = offset;
            const ScreenRect r = footprint(view, s).rect;
            for (int y = 0; y < 200; ++y)
                for (int x = 0; x < 200; ++x)
                    if (!holds(r, x, y)) {
                        ASSERT_FALSE(meets_patch(view, s, x, y)) << x << ' ' << y;
                    }
        }
}

/// Blocks of the tile about a surfel that its outline is said to touch;
/// other lanes hold surfels of other sizes.
BlockMask listed_blocks(const PixelView& view, const Surfel& s, std::size_t lane, TileBuffers& t) {
    const Footprint foot = footprint(view, s);
    t.x0 = static_cast<int>(foot.pixel_x) - 16, t.y0 = static_cast<int>(foot.pixel_y) - 16;
    t.clip = {t.x0, t.y0, t.x0 + kTileSize, t.y0 + kTileSize};
    BlockSpans spans;
    for (std::size_t k = 0; k < kLanes; ++k) {
        Surfel other = s;
        other.support_radius *= 0.3 + 0.1 * static_cast<double>(k);
        spans.set(k, k == lane ? foot : footprint(view, other));
    }
    spans.find(t);
    return spans.blocks(lane);
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
            const BlockMask listed = listed_blocks(view, s, seed % kLanes, *t);
            std::array<bool, kTileBlocks> touched{};
            for (int y = 0; y < kTileSize; ++y)
                for (int x = 0; x < kTileSize; ++x) {
                    if (t->x0 + x < 0 || t->y0 + y < 0 || t->x0 + x >= 200 || t->y0 + y >= 200)
                        continue;
                    if (!meets_patch(view, s, t->x0 + x, t->y0 + y)) continue;
                    const std::size_t block = pixel_entry(x, y) / kLanes;
                    touched[block] = true;
                    ASSERT_TRUE(listed.has(static_cast<int>(block))) << x << ' ' << y;
                }
            for (int block = 0; block < kTileBlocks; ++block) in_list += listed.has(block);
            for (const bool b : touched) met += b;
        }
    EXPECT_GT(met, 1000);
    EXPECT_LT(in_list, 1.25 * met);
}

TEST(BlockList, HoldsTheBlocksOfEachSurfelInOrder) {
    BlockList list;
    std::vector<std::pair<int, int>> expected;
    for (int surfel = 0; surfel < BlockList::kMostSurfels; ++surfel) {
        BlockMask mask;
        for (int block = 0; block < kTileBlocks; ++block) {
            // None, all, or some.
            if (surfel == 3 ||
                (surfel != 5 &&
                 keyed_hash(7, static_cast<std::uint64_t>(surfel * kTileBlocks + block)) % 3 != 0))
                continue;
            mask.add(static_cast<std::size_t>(block), 1);
            expected.emplace_back(surfel, block);
        }
        EXPECT_EQ(mask.any(), surfel != 3);
        list.add(surfel, mask);
    }
    ASSERT_EQ(list.size(), static_cast<int>(expected.size()));
    for (int k = 0; k < list.size(); ++k) {
        EXPECT_EQ(list.surfel(k), expected[static_cast<std::size_t>(k)].first);
        EXPECT_EQ(list.block(k), expected[static_cast<std::size_t>(k)].second);
    }
}

TEST(TileBuffers, BoundsOfBlocksAreThoseOfTheirPixels) {
    auto t = std::make_unique<TileBuffers>();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < kTilePixels; ++i) {
        const double x = uniform(11, i);
        t->z.v[i] = x > 0.9    ? kInfinity
                    : x < -0.9 ? -kInfinity
                               : static_cast<float>(x + 0.01 * static_cast<double>(i / kLanes));
    }
    std::fill_n(t->z.v, kLanes, kInfinity);            // no hit in the first block,
    std::fill_n(t->z.v + kLanes, kLanes, -kInfinity);  // nothing of the window in the second
    const auto block = [&](int k) { return std::span(t->z.v + k * kLanes, kLanes); };
    EXPECT_EQ(t->bound_pixels(), kInfinity);
    for (int k = 0; k < kTileBlocks; ++k)
        EXPECT_EQ(t->block_far[k], *std::max_element(block(k).begin(), block(k).end())) << k;
    for (int k = 0; k < kTileBlocks; ++k)
        EXPECT_EQ(t->beyond(0.2f).has(k), t->block_far[k] > 0.2f) << k;
    ASSERT_TRUE(t->bound_hits());
    EXPECT_FALSE(t->within(-1e9f, 1e9f).has(0));
    EXPECT_FALSE(t->within(-1e9f, 1e9f).has(1));
    for (int k = 2; k < kTileBlocks; ++k) {
        float near = kInfinity, far = -kInfinity;
        for (const float z : block(k))
            if (std::isfinite(z)) near = std::min(near, z), far = std::max(far, z);
        EXPECT_EQ(t->block_near[k], near) << k;
        EXPECT_EQ(t->block_far[k], far) << k;
        EXPECT_EQ(t->within(0.1f, 0.2f).has(k), near <= 0.2f && far >= 0.1f) << k;
    }
}

}  // namespace
}  // namespace slim
