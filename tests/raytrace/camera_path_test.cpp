#include "raytrace/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

TEST(CameraPath, PassesItsKeyframesAndStaysSmooth) {
    Camera a, b, c;
    a.eye = {0, 0, 5};
    b.eye = {5, 1, 0}, b.target = {0, 1, 0}, b.fov_y_deg = 50;
    c.eye = {0, 8, -5}, c.up = {0, 1, 0.2};
    const Camera keys[] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
        const Camera at = camera_on_path(keys, k);
        EXPECT_LT(length(at.eye - keys[k].eye), 1e-9) << k;
        EXPECT_LT(length(at.target - keys[k].target), 1e-9) << k;
        EXPECT_NEAR(at.fov_y_deg, keys[k].fov_y_deg, 1e-9) << k;
        EXPECT_NO_THROW(validate(at));
    }
    // No jump of place or speed: second differences stay of the size of a step's square.
    const double step = 0.01;
    Vec3d before = camera_on_path(keys, 0).eye, now = camera_on_path(keys, step).eye;
    for (int i = 2; i <= 200; ++i) {
        const Vec3d next = camera_on_path(keys, i * step).eye;
        EXPECT_LT(length(next - now), 0.3) << i;
        EXPECT_LT(length(next - now * 2 + before), 0.02) << i;
        before = now, now = next;
    }
}

TEST(CameraPath, RestsBetweenEqualKeyframes) {
    Camera a, b;
    a.eye = {0.1, 0, 5}, a.fov_y_deg = 33;
    b.eye = {5, 1, 0}, b.target = {0, 1, 0};
    const Camera keys[] = {a, a, b, b, b};
    const auto moved = [&](double t, const Camera& from) {
        return length(camera_on_path(keys, t).eye - from.eye);
    };
    const Vec3d rest = camera_on_path(keys, 0).eye;
    for (const double t : {0.01, 0.5, 0.99, 1.0})  // the bytes of the first picture
        EXPECT_EQ(camera_on_path(keys, t).eye, rest) << t;
    for (const double t : {2.0, 2.3, 3.5, 4.0}) EXPECT_LT(moved(t, b), 1e-12) << t;
    // It leaves slowly and comes to rest slowly, and passes neither.
    EXPECT_LT(moved(1.01, a), 0.01);
    EXPECT_LT(moved(1.99, b), 0.01);
    EXPECT_GT(moved(1.5, a), 1);
}

TEST(CameraPath, AFullTurnComesBackAndKeepsItsDistance) {
    Camera camera;
    camera.eye = {1, 2, 5}, camera.target = {0, 0, 1};
    const Vec3d center{0.5, 0, 0}, axis{0, 3, 0};
    EXPECT_LT(length(turned(camera, center, axis, 360).eye - camera.eye), 1e-12);
    const Camera quarter = turned(camera, center, axis, 90);
    EXPECT_NEAR(length(quarter.eye - quarter.target), length(camera.eye - camera.target), 1e-12);
    EXPECT_LT(length(quarter.eye - Vec3d{5.5, 2, -0.5}), 1e-12);
}

TEST(NamedCamera, ATurntableKeepsEveryPositionInThePicture) {
    const Bbox box{{-3, -1, -0.5}, {3, 1, 0.5}};
    for (const bool orthographic : {false, true}) {
        const Camera camera =
            named_camera("front", box, 1.5, {.orthographic = orthographic, .turns = 12});
        for (int k = 0; k < 12; ++k) {
            const PixelView view =
                pixel_view(turned(camera, box.center(), {0, 1, 0}, 30 * k), 300, 200);
            for (unsigned i = 0; i < 8; ++i) {
                const Vec3d p = view.camera_from_local(
                    {i & 1u ? 3.0 : -3.0, i & 2u ? 1.0 : -1.0, i & 4u ? 0.5 : -0.5});
                const double scale = orthographic ? view.px_per_unit : view.focal_px / p.z;
                EXPECT_LE(std::abs(p.x * scale), 150) << k;
                EXPECT_LE(std::abs(p.y * scale), 100) << k;
            }
        }
    }
}

}  // namespace
}  // namespace slim
