#include "raytrace/camera.h"

#include "raytrace/renderer.h"
#include "slim/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

namespace slim {
namespace {

Bbox unit_box() {
    Bbox box;
    box.extend(Vec3d{-1, -2, -0.5});
    box.extend(Vec3d{1, 2, 0.5});
    return box;
}

TEST(Camera, PixelsRunFromTheTopLeftAndUpIsUp) {
    Camera camera{{0, 0, 5}, {0, 0, 0}, {0, 1, 0}};
    const PixelView view = pixel_view(camera, 40, 20);
    const Vec3d center = view.ray_direction(20, 10);
    EXPECT_NEAR(center.z, -1, 1e-15);
    const Vec3d corner = view.ray_direction(0.5, 0.5);
    EXPECT_LT(corner.x, 0);
    EXPECT_GT(corner.y, 0);
    const Vec3d top = view.ray_direction(20, 0);
    EXPECT_NEAR(std::atan2(top.y, -top.z) * 180 / 3.14159265358979, 17.5, 1e-9);
    const Vec3d p = view.point_at(3.5, 7.5, 4);
    const Vec3d c = view.camera_from_local(p);
    EXPECT_NEAR(c.z, 4, 1e-12);
    EXPECT_NEAR(view.center_x + view.focal_px * c.x / c.z, 3.5, 1e-12);
    EXPECT_NEAR(view.center_y + view.focal_px * c.y / c.z, 7.5, 1e-12);
}

TEST(Camera, NamedViewsFrameTheBox) {
    for (const char* name : {"front", "back", "left", "right", "top", "bottom", "iso"})
        for (const UpAxis up : {UpAxis::y, UpAxis::z, UpAxis::minus_x})
            for (const bool orthographic : {false, true})
                for (const double aspect : {0.5, 1.0, 2.0}) {
                    Framing framing;
                    framing.up = up, framing.orthographic = orthographic;
                    const int height = 100, width = static_cast<int>(height * aspect);
                    const PixelView v =
                        pixel_view(named_camera(name, unit_box(), aspect, framing), width, height);
                    double border = 1e9;
                    for (int corner = 0; corner < 8; ++corner) {
                        const Vec3d p{corner & 1 ? 1. : -1., corner & 2 ? 2. : -2.,
                                      corner & 4 ? .5 : -.5};
                        const Vec3d c = v.camera_from_local(p);
                        const double scale = orthographic ? v.px_per_unit : v.focal_px / c.z;
                        EXPECT_GT(c.z, v.near_plane);
                        const double x = v.center_x + scale * c.x, y = v.center_y + scale * c.y;
                        border = std::min({border, x, width - x, y, height - y});
                    }
                    // Some corner touches the margin: 4 % of the half width or height, or it is
                    // missed.
                    EXPECT_GT(border, 0.019 * std::min(width, height)) << name;
                    EXPECT_LT(border, 0.021 * std::max(width, height)) << name;
                }
}

/// The largest and the least pixel coordinate of the unit box's corners, across or down the
/// picture.
struct Span {
    double least = 1e9, most = -1e9;
};

Span span_of_box(const Camera& camera, int width, int height, bool across) {
    const PixelView v = pixel_view(camera, width, height);
    Span span;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p{corner & 1 ? 1. : -1., corner & 2 ? 2. : -2., corner & 4 ? .5 : -.5};
        const Vec3d c = v.camera_from_local(p);
        EXPECT_GT(c.z, v.near_plane);
        const double scale = v.orthographic ? v.px_per_unit : v.focal_px / c.z;
        const double at = across ? v.center_x + scale * c.x : v.center_y + scale * c.y;
        span.least = std::min(span.least, at), span.most = std::max(span.most, at);
    }
    return span;
}

TEST(Camera, AFreeRightSideStaysFree) {
    for (const char* name : {"front", "back", "left", "right", "top", "bottom", "iso"})
        for (const bool orthographic : {false, true})
            for (const double aspect : {0.5, 1.0, 2.0})
                for (const double free_right : {0.2, 0.6}) {
                    SCOPED_TRACE(std::string(name) + " " + std::to_string(aspect));
                    const Camera c = named_camera(
                        name, unit_box(), aspect,
                        {.orthographic = orthographic, .free_right = free_right});
                    const int height = 100, width = static_cast<int>(height * aspect);
                    const Span x = span_of_box(c, width, height, true);
                    const Span y = span_of_box(c, width, height, false);
                    EXPECT_LE(x.most, (0.98 - free_right) * width + 1e-6);
                    EXPECT_GE(x.least, 0.02 * width - 1e-6);
                    EXPECT_GE(y.least, 0.02 * height - 1e-6);
                    EXPECT_LE(y.most, 0.98 * height + 1e-6);
                    // It fills what is left: from side to side, or from top to bottom.
                    EXPECT_TRUE(x.least < 0.021 * width || y.most > 0.979 * height ||
                                y.least < 0.021 * height);
                }
}

TEST(Camera, NamedViewsLeaveTheBottomFreeAndFillTheRest) {
    for (const char* name : {"front", "back", "left", "right", "top", "bottom", "iso"})
        for (const bool orthographic : {false, true})
            for (const double aspect : {0.5, 1.0, 2.0})
                for (const double free_right : {0.0, 0.2}) {
                    SCOPED_TRACE(std::string(name) + " " + std::to_string(aspect));
                    const Camera c = named_camera(name, unit_box(), aspect,
                                                  {.orthographic = orthographic,
                                                   .free_right = free_right,
                                                   .free_bottom = 0.15});
                    const int height = 100, width = static_cast<int>(height * aspect);
                    const Span x = span_of_box(c, width, height, true);
                    const Span y = span_of_box(c, width, height, false);
                    EXPECT_LE(x.most, (0.98 - free_right) * width + 1e-6);
                    EXPECT_GE(x.least, 0.02 * width - 1e-6);
                    EXPECT_GE(y.least, 0.02 * height - 1e-6);
                    EXPECT_LE(y.most, (0.98 - 0.15) * height + 1e-6);
                    EXPECT_TRUE(x.least < 0.021 * width || y.least < 0.021 * height ||
                                x.most > (0.979 - free_right) * width || y.most > 0.829 * height);
                }
}

TEST(Camera, AFreeRightSideIsNoReasonToMoveWhereThereIsRoom) {
    for (const bool orthographic : {false, true}) {
        const Camera centred = named_camera("front", unit_box(), 3, {.orthographic = orthographic});
        const Camera beside = named_camera(
            "front", unit_box(), 3, {.orthographic = orthographic, .free_right = 0.2});
        EXPECT_EQ(centred.eye, beside.eye);
        EXPECT_EQ(centred.target, beside.target);
        EXPECT_EQ(centred.width, beside.width);
    }
}

TEST(Camera, FrontLooksAlongMinusZOrInATerrainAlongY) {
    Camera camera = named_camera("front", unit_box(), 1);
    EXPECT_GT(camera.eye.z, 0.5);
    EXPECT_EQ(camera.up, (Vec3d{0, 1, 0}));
    camera = named_camera("front", unit_box(), 1, {.up = UpAxis::z});
    EXPECT_LT(camera.eye.y, -2);
    EXPECT_EQ(camera.up.z, 1);
    camera = named_camera("right", unit_box(), 1);
    EXPECT_GT(camera.eye.x, 1);
}

TEST(Camera, EveryAxisMayBeUpAndViewsAreNeverMirrored) {
    for (const UpAxis up :
         {UpAxis::y, UpAxis::z, UpAxis::x, UpAxis::minus_y, UpAxis::minus_z, UpAxis::minus_x}) {
        const Vec3d axis = up_vector(up);
        EXPECT_EQ(length(axis), 1);
        const auto towards = [&](const char* name) {
            const Camera c = named_camera(name, unit_box(), 1, {.up = up});
            return normalized(c.eye - c.target);
        };
        EXPECT_EQ(named_camera("front", unit_box(), 1, {.up = up}).up, axis);
        EXPECT_NEAR(dot(towards("top"), axis), 1, 1e-12);
        EXPECT_NEAR(dot(towards("front"), axis), 0, 1e-12);
        // Seen from the front, right is to the right: up x front.
        EXPECT_NEAR(dot(cross(axis, towards("front")), towards("right")), 1, 1e-12);
    }
}

TEST(Camera, AnUnknownNameIsAConfigErrorThatListsTheKnown) {
    try {
        named_camera("frnt", unit_box(), 1);
        FAIL();
    } catch (const ConfigError& e) {
        EXPECT_NE(std::string(e.what()).find("front, back"), std::string::npos);
    }
    EXPECT_TRUE(is_camera_name("iso"));
    EXPECT_FALSE(is_camera_name("frnt"));
}

TEST(Camera, AFlatOrEmptyBoxIsStillFramed) {
    Bbox point;
    point.extend(Vec3d{3, 4, 5});
    for (const Bbox& box : {point, Bbox{}})
        for (const bool orthographic : {false, true})
            EXPECT_NO_THROW(
                validate(named_camera("iso", box, 1.5, {.orthographic = orthographic})));
}

TEST(Camera, ValidationNamesWhatIsWrong) {
    const Camera good{{0, 0, 5}, {0, 0, 0}, {0, 1, 0}};
    EXPECT_NO_THROW(validate(good));
    Camera c = good;
    c.target = c.eye;
    EXPECT_THROW(validate(c), ConfigError);
    c = good, c.up = {0, 0, 3};
    EXPECT_THROW(validate(c), ConfigError);
    // Each is blamed for what it is, not another one.
    const auto blame = [](const Camera& camera) -> std::string {
        try {
            validate(camera);
            return "";
        } catch (const ConfigError& e) {
            return e.what();
        }
    };
    c = good, c.eye = {0, 0, 1e300};
    EXPECT_NE(blame(c).find("camera: eye (0, 0, 1e+300) must lie"), std::string::npos) << blame(c);
    c = good, c.up = {0, 1e300, 0};
    EXPECT_NE(blame(c).find("camera: up must be"), std::string::npos) << blame(c);
    c = good, c.up = {};
    EXPECT_EQ(blame(c), "camera: up is zero");
    c = good, c.up = {};
    EXPECT_THROW(validate(c), ConfigError);
    c = good, c.fov_y_deg = 180;
    EXPECT_THROW(validate(c), ConfigError);
    c = good, c.orthographic = true, c.width = 0;
    EXPECT_THROW(validate(c), ConfigError);
    c = good, c.eye.x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(validate(c), ConfigError);
    c = good, c.near_plane = -1;
    EXPECT_THROW(validate(c), ConfigError);
    EXPECT_THROW(pixel_view(good, 0, 5), ConfigError);
}

TEST(RenderRequest, AWindowMustLieInThePicture) {
    RenderRequest request;
    request.width = 100, request.height = 50;
    EXPECT_EQ(request.resolved_window().width, 100);
    request.window = {90, 0, 10, 50};
    EXPECT_EQ(request.resolved_window().x, 90);
    for (const PixelWindow w : {PixelWindow{91, 0, 10, 50}, PixelWindow{-1, 0, 5, 5},
                                PixelWindow{0, 0, 5, 0}, PixelWindow{0, 0, 5, 51}}) {
        request.window = w;
        EXPECT_THROW(request.resolved_window(), ConfigError);
    }
}

}  // namespace
}  // namespace slim
