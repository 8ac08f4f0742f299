#include "raytrace/legend_room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace slim {
namespace {

const LegendRoom kRoom{0.22, 0.2, 0.22, 0.52};

Framed box_of(double x, double y, double z) {
    Bbox box;
    box.extend(Vec3d{-x, -y, -z});
    box.extend(Vec3d{x, y, z});
    return {box};
}

/// The part of a picture 100 high that the corners of a box take, shares of its sides.
struct Seen {
    double left = 1, right = 0, top = 1, bottom = 0;

    Seen(const Camera& camera, const Bbox& box, double aspect) {
        const int width = static_cast<int>(100 * aspect);
        const PixelView v = pixel_view(camera, width, 100);
        for (unsigned i = 0; i < 8; ++i) {
            const Vec3d c = v.camera_from_local({i & 1u ? box.hi.x : box.lo.x,
                                                 i & 2u ? box.hi.y : box.lo.y,
                                                 i & 4u ? box.hi.z : box.lo.z});
            const double scale = v.orthographic ? v.px_per_unit : v.focal_px / c.z;
            const double x = (v.center_x + c.x * scale) / width,
                         y = (v.center_y + c.y * scale) / 100;
            left = std::min(left, x), right = std::max(right, x);
            top = std::min(top, y), bottom = std::max(bottom, y);
        }
    }
};

Seen seen(const Framed& framed, double aspect, const Framing& framing,
          const LegendRoom& room = kRoom) {
    return Seen(framed_beside("front", framed, aspect, framing, room).camera, framed.box, aspect);
}

TEST(LegendRoom, AWideThingOnASquareSheetHasItBelow) {
    for (const bool orthographic : {false, true}) {
        const Seen s = seen(box_of(1.2, 1, 0.05), 1, {.orthographic = orthographic});
        EXPECT_GT(s.right - s.left, 0.9);
        EXPECT_LE(s.bottom, 0.8);
    }
}

TEST(LegendRoom, AThingThatFillsTheHeightHasItAtTheRight) {
    const Seen s = seen(box_of(1, 1, 0.05), 1.5, {.orthographic = true});
    EXPECT_GT(s.bottom - s.top, 0.9);
    EXPECT_LE(s.right, 0.78);
}

TEST(LegendRoom, SharesTheStripOfAScaleBar) {
    const Seen s = seen(box_of(1.2, 1, 0.05), 1, {.orthographic = true, .free_bottom = 0.11});
    EXPECT_LE(s.bottom, 0.8);
    EXPECT_GT(s.right - s.left, 0.9);
}

TEST(LegendRoom, ACornerThatIsFreeAnywayTakesNothing) {
    // A lozenge, as terrain from half above.
    const std::vector<Vec3d> lozenge{{-1, 0, 0}, {1, 0, 0}, {0, -0.6, 0}, {0, 0.6, 0}};
    Bbox box;
    for (const Vec3d& p : lozenge) box.extend(p);
    const LegendRoom key{0.2, 0.13, 0.2, 0.13};
    for (const bool orthographic : {false, true}) {
        const Framing framing{.orthographic = orthographic};
        const auto width = [&](const FramedCamera& c) {
            return c.camera.orthographic ? c.camera.width : length(c.camera.eye - c.camera.target);
        };
        const Framed framed(box, lozenge), filled(box);
        EXPECT_EQ(width(framed_beside("front", framed, 1, framing, key)),
                  width(framed_camera("front", framed, 1, framing)));
        // Its box has no free corner in a picture that it fills.
        EXPECT_GT(width(framed_beside("front", filled, 1.0 / 0.6, framing, key)),
                  width(framed_camera("front", filled, 1.0 / 0.6, framing)));
    }
}

TEST(LegendRoom, ALowerLeftCornerIsTheScaleBars) {
    // All corners but the lower left are taken.
    const std::vector<Vec3d> places{{-1, 1, 0}, {1, 1, 0}, {1, -1, 0}};
    Bbox box;
    for (const Vec3d& p : places) box.extend(p);
    const LegendRoom key{0.2, 0, 0.2, 0.15};
    const auto width = [&](double bar) {
        return framed_beside("front", {box, places}, 1,
                             {.orthographic = true, .free_bottom = bar}, key)
            .camera.width;
    };
    EXPECT_LT(width(0), 2.1);
    EXPECT_GT(width(1e-9), 2.3);
}

TEST(LegendRoom, AScaleBarsCornerThatIsFreeAnywayTakesNoStrip) {
    // All corners but the lower right are free in the one, all but the lower left in the other.
    const std::vector<Vec3d> clear{{1, -1, 0}, {-1, 1, 0}, {1, 1, 0}},
        taken{{-1, -1, 0}, {-1, 1, 0}, {1, 1, 0}};
    Bbox box;
    for (const Vec3d& p : clear) box.extend(p);
    const Framing framing{.orthographic = true, .free_bottom = 0.11};
    const LegendRoom bar{0, 0, 0, 0, 0.34, 0.11};
    const auto width = [&](const std::vector<Vec3d>& places, Framing with, const LegendRoom& room) {
        return framed_beside("front", {box, places}, 1, with, room).camera.width;
    };
    EXPECT_LT(width(clear, framing, bar), 2.1);
    EXPECT_GT(width(clear, framing, {}), 2.2);
    EXPECT_EQ(width(taken, framing, bar), width(taken, framing, {}));
    // Films turn what is free.
    Framing turning = framing;
    turning.turns = 12;
    EXPECT_EQ(width(clear, turning, bar), width(clear, turning, {}));
    // A legend has another corner, or its strip.
    LegendRoom both = bar;
    both.right = both.corner_width = 0.22, both.corner_height = 0.3;
    EXPECT_GT(width(clear, framing, both), 2.3);
    const std::vector<Vec3d> lozenge{{-1, 0, 0}, {1, 0, 0}, {0, -0.6, 0}, {0, 0.6, 0}};
    EXPECT_EQ(width(lozenge, framing, both), width(lozenge, {.orthographic = true}, {}));
}

TEST(LegendRoom, TurntablesAndStripsAtTheRightKeepThat) {
    const Framed wide = box_of(1.2, 1, 0.05);
    EXPECT_LE(seen(wide, 1, {.orthographic = true, .turns = 12}).right, 0.78);
    EXPECT_LE(seen(wide, 1, {.orthographic = true}, LegendRoom::strip_at_right(0.22)).right, 0.78);
    const Seen none = seen(wide, 1, {.orthographic = true}, {});
    EXPECT_NEAR(none.left, 1 - none.right, 1e-9);
    EXPECT_NEAR(none.top, 1 - none.bottom, 1e-9);
}

TEST(LegendRoom, IsLeftUntilWhatIsSeenFillsMostOfIt) {
    const Framed box = box_of(1, 1, 0.05);
    const auto left_by = [&](double width, const LegendRoom& room) {
        Camera camera = framed_camera("front", box, 1.5, {.orthographic = true}).camera;
        camera.width = width;  // the box takes 2 of it, and of the height 3 of it
        return leaves_room(camera, box, 1.5, room);
    };
    const LegendRoom right{0.2, 0, 0, 0}, below{0, 0.2, 0, 0}, corner{0, 0, 0.2, 0.2};
    for (const LegendRoom& room : {right, below, corner}) EXPECT_TRUE(left_by(6, room));
    EXPECT_TRUE(left_by(3, right));
    EXPECT_FALSE(left_by(3, below));  // all of the height
    EXPECT_TRUE(left_by(3, corner));  // beside it
    EXPECT_TRUE(left_by(2.9, right) && !left_by(2.2, right));
    for (const LegendRoom& room : {right, below, corner}) EXPECT_FALSE(left_by(2, room));
    EXPECT_FALSE(left_by(6, {}));
}

}  // namespace
}  // namespace slim
