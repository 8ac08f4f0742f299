#include "raytrace/camera_path.h"

#include "slim/base/angle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace slim {
namespace {

/// As lopsided as a scan: nothing of it is in half of its box.
constexpr std::array<Vec3d, 5> kPlaces{
    {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}, {0, 0, 2}, {0.5, 2.5, 0.25}}};

Bbox box_of_places() {
    Bbox box;
    for (const Vec3d& p : kPlaces) box.extend(p);
    return box;
}

/// Shares of the picture that stay free beside what is framed.
struct Margins {
    double left = 1, right = 1, top = 1, bottom = 1;
};

Margins margins(const Camera& camera, int width, int height) {
    const PixelView v = pixel_view(camera, width, height);
    Margins m;
    for (const Vec3d& p : kPlaces) {
        const Vec3d c = v.camera_from_local(p);
        const double scale = v.orthographic ? v.px_per_unit : v.focal_px / c.z;
        const double x = (v.center_x + scale * c.x) / width,
                     y = (v.center_y + scale * c.y) / height;
        m.left = std::min(m.left, x), m.right = std::min(m.right, 1 - x);
        m.top = std::min(m.top, y), m.bottom = std::min(m.bottom, 1 - y);
    }
    return m;
}

TEST(Framing, PlacesStandInTheMiddleBothWaysAndFillOneOfThem) {
    for (const char* name : {"front", "back", "left", "right", "top", "bottom", "iso"})
        for (const bool orthographic : {false, true})
            for (const double fov : {5.0, 35.0, 60.0})
                for (const int width : {50, 100, 200}) {
                    SCOPED_TRACE(std::string(name) + " " + std::to_string(width));
                    const Camera c = named_camera(name, {box_of_places(), kPlaces}, width / 100.0,
                                                  {.orthographic = orthographic, .fov_y_deg = fov});
                    const Margins m = margins(c, width, 100);
                    EXPECT_NEAR(m.left, m.right, 1e-9);
                    EXPECT_NEAR(m.top, m.bottom, 1e-9);
                    EXPECT_NEAR(std::min(m.left, m.top), 0.02, 1e-9);
                }
}

TEST(Framing, BesideARoomThatStaysFreePlacesStandAsNearTheMiddleAsTheyCan) {
    for (const bool orthographic : {false, true})
        for (const int width : {100, 300}) {
            const FramedCamera f = framed_camera(
                "iso", {box_of_places(), kPlaces}, width / 100.0,
                {.orthographic = orthographic, .free_right = 0.2, .free_bottom = 0.15});
            const Margins m = margins(f.camera, width, 100);
            EXPECT_NEAR(m.bottom, 0.17, 1e-9);
            EXPECT_GE(m.right, 0.22 - 1e-9);
            EXPECT_GE(std::min(m.left, m.top), 0.02 - 1e-9);
            // In the wide picture there is room beside what must stay free.
            if (width == 300) {
                EXPECT_NEAR(m.left, m.right, 1e-9);
            }
            // Enlarged about their middle they are as large on either side of it.
            constexpr double kZoom = 1.25;
            Camera near = f.camera;
            near.eye += f.to_middle * (1 - 1 / kZoom), near.target += f.to_middle * (1 - 1 / kZoom);
            near.width /= kZoom;
            near.fov_y_deg = 2 * std::atan(std::tan(radians(near.fov_y_deg) / 2) / kZoom) * 180 /
                             std::numbers::pi;
            const Margins zoomed = margins(near, width, 100);
            EXPECT_NEAR(zoomed.left - zoomed.right, m.left - m.right, 1e-6);
            EXPECT_NEAR(zoomed.top - zoomed.bottom, m.top - m.bottom, 1e-6);
        }
}

TEST(Framing, AllOfATurnStaysInThePicture) {
    constexpr int kTurns = 12;
    const Bbox box = box_of_places();
    Framing framing;
    framing.turns = kTurns;
    const Camera whole = named_camera("iso", {box, kPlaces}, 1, framing);
    double least = 1;
    for (int k = 0; k < kTurns; ++k) {
        const Margins m =
            margins(turned(whole, box.center(), {0, 1, 0}, 360.0 * k / kTurns), 100, 100);
        least = std::min({least, m.left, m.right, m.top, m.bottom});
    }
    EXPECT_NEAR(least, 0.02, 1e-9);
}

TEST(Framing, AWideViewOfSomethingPointedKeepsClearOfItsTip) {
    for (const double fov : {100.0, 170.0}) {
        const Camera c = named_camera("right", {box_of_places(), kPlaces}, 1, {.fov_y_deg = fov});
        EXPECT_GT(c.eye.x, 4.01);
        const Margins m = margins(c, 100, 100);
        EXPECT_NEAR(m.left, m.right, 1e-9);
        EXPECT_NEAR(m.top, m.bottom, 1e-9);
        EXPECT_GE(std::min(m.left, m.top), 0.02 - 1e-9);
    }
}

TEST(Framing, WhatHasNoExtentIsInTheMiddle) {
    const std::array<Vec3d, 2> place{{{1, 2, 3}, {1, 2, 3}}};
    Bbox box;
    box.extend(place[0]);
    for (const bool orthographic : {false, true}) {
        const Camera c = named_camera("iso", {box, place}, 1, {.orthographic = orthographic});
        EXPECT_EQ(c.target, place[0]);
        EXPECT_NEAR(length(c.eye - c.target), 1, 1e-9);
    }
}

}  // namespace
}  // namespace slim
