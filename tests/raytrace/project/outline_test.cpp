#include "raytrace/project/outline.h"

#include "tests/raytrace/project/patch_support.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace slim {
namespace {

using test::footprint, test::holds, test::meets_patch, test::random_surfel, test::view_of;

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

}  // namespace
}  // namespace slim
