#include "raytrace/project/pixel_records.h"

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/outline.h"
#include "slim/model/surfel_tree.h"
#include "tests/raytrace/project/patch_support.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace slim {
namespace {

using test::add, test::footprint, test::footprints, test::lanes_of, test::random_surfel,
    test::uniform, test::view_of;

using OneLane = stdx::simd<float, stdx::simd_abi::scalar>;

/// f, |q|^2 and the gradient at a pixel's ray and a depth, straight from the surfel.
struct Direct {
    double f, sq_distance;
    Vec3d local, gradient;

    Direct(const PixelView& view, const Surfel& s, int x, int y, double z) {
        const Vec3d q = (view.point_at(x + 0.5, y + 0.5, z) - s.center) / s.support_radius;
        local = s.frame.local_from_world(q);
        f = local.z - s.polynomial.value(local.x, local.y);
        sq_distance = sq_length(q);
        gradient = view.rotate_to_camera(world_gradient(s, local.x, local.y));
    }
};

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
        EXPECT_EQ(records[k].a, alone.a);
        const Footprint foot = footprint(view, surfels[k]);
        EXPECT_EQ(feet[k].rect.x0, foot.rect.x0);
        EXPECT_EQ(feet[k].outline.c2, foot.outline.c2);
        EXPECT_EQ(feet[k].pixel_x, records[k].pixel_x);
        EXPECT_EQ(feet[k].step, records[k].step);
    }
}

}  // namespace
}  // namespace slim
