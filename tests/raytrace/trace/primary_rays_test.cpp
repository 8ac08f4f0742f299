#include "raytrace/trace/primary_rays.h"

#include <gtest/gtest.h>

#include <cstddef>

// Packets against the rays of single pixels.

namespace slim {
namespace {

Vec3d two(const LanesOfVec& high, const LanesOfVec& low, int lane) {
    return to_double(high.at(lane)) + to_double(low.at(lane));
}

/// A block that the window ends in, right and below.
PixelBlock partial_block(int width, int height) {
    const int x = (width - 1) / kPacketWidth * kPacketWidth,
              y = (height - 1) / kPacketHeight * kPacketHeight;
    return {x, y, {0, 0, width, height}};
}

TEST(PrimaryRays, ArePixelViewsInEveryLaneThatThePictureHas) {
    constexpr int kWidth = 61, kHeight = 45;
    const SceneFrame frame{{1, 2, 3}, 2.5};
    for (const bool orthographic : {false, true}) {
        Camera camera;
        camera.eye = {8, 5, 9}, camera.target = frame.middle;
        camera.orthographic = orthographic, camera.width = 3,
        camera.fov_y_deg = 15;  // all rays meet the scene's sphere
        const PixelView view = pixel_view(camera, kWidth, kHeight);
        for (const PixelBlock& block :
             {partial_block(kWidth, kHeight), PixelBlock{20, 20, {0, 0, kWidth, kHeight}}}) {
            const RayPacket rays = primary_rays(view, frame, block);
            for (int lane = 0; lane < kLanes; ++lane) {
                SCOPED_TRACE(lane);
                const bool has_ray =
                    static_cast<float>(rays.far[static_cast<std::size_t>(lane)]) >= 0;
                ASSERT_EQ(has_ray, block.x_of(lane) < kWidth && block.y_of(lane) < kHeight);
                if (!has_ray) continue;
                const double px = block.x_of(lane) + 0.5, py = block.y_of(lane) + 0.5;
                // Two floats of numbers of about 1.
                ASSERT_LT(length(two(rays.direction, rays.direction_low, lane) -
                                 view.ray_direction(px, py)),
                          1e-14);
                const Vec3d from =
                    frame.to_job(two(rays.origin, rays.origin_low, lane)) - view.ray_origin(px, py);
                ASSERT_GT(dot(from, view.ray_direction(px, py)), 0);
                ASSERT_LT(length(cross(from, view.ray_direction(px, py))), 1e-13);
                ASSERT_NEAR(length(to_double(rays.origin.at(lane))), 1, 1e-3);  // where it enters
            }
        }
    }
}

TEST(PrimaryRays, RaysThatMissTheSceneAreNone) {
    Camera camera;
    camera.eye = {0, 0, 9}, camera.target = {5, 0, 9};
    const RayPacket rays =
        primary_rays(pixel_view(camera, 64, 64), {{0, 0, 0}, 1}, {32, 32, {0, 0, 64, 64}});
    EXPECT_TRUE(stdx::none_of(rays.active()));
}

}  // namespace
}  // namespace slim
