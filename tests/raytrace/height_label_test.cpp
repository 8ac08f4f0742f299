#include "raytrace/height_label.h"

#include "raytrace/crop.h"
#include "raytrace/font.h"
#include "raytrace/hillshade.h"
#include "tests/raytrace/lines/relief_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace slim {
namespace {

HeightLabel label_at(float x, float y, float angle) {
    HeightLabel label{"450 m", x, y, angle, 0, 12};
    label.width = text_width(label.text, {.cap_height = 12});
    return label;
}

Picture white(int width, int height) {
    Picture p(width, height);
    std::fill(p.rgba.begin(), p.rgba.end(), 1.0f);
    return p;
}

/// Where the dark pixels of a picture lie on average, and how far from there along an angle.
struct Inked {
    double x = 0, y = 0, along = 0, across = 0, n = 0;

    Inked(const Picture& p, double angle) {
        const auto each = [&](const auto& visit) {
            for (int v = 0; v < p.height; ++v)
                for (int u = 0; u < p.width; ++u)
                    if (p.pixel(u, v)[1] < 0.5f) visit(u + 0.5, v + 0.5);
        };
        each([&](double u, double v) { x += u, y += v, ++n; });
        x /= n, y /= n;
        each([&](double u, double v) {
            const double a = (u - x) * std::cos(angle) + (v - y) * std::sin(angle);
            const double b = (v - y) * std::cos(angle) - (u - x) * std::sin(angle);
            along = std::max(along, std::abs(a)), across = std::max(across, std::abs(b));
        });
    }
};

TEST(HeightLabel, IsWrittenAboutItsMiddleAlongItsAngle) {
    for (const float angle : {0.0f, 0.6f, -1.2f, 3.0f}) {
        Picture p = white(120, 120);
        const HeightLabel label = label_at(60, 60, angle);
        draw_height_labels(std::vector{label}, p);
        const Inked ink(p, static_cast<double>(angle));
        EXPECT_NEAR(ink.x, 60, 3) << angle;
        EXPECT_NEAR(ink.y, 60, 3) << angle;
        EXPECT_NEAR(ink.along, static_cast<double>(label.width) / 2, 4) << angle;
        EXPECT_NEAR(ink.across, 6, 2) << angle;
    }
}

TEST(HeightLabel, UpsideDownIsTheUprightOneTurned) {
    Picture up = white(120, 60), down = white(120, 60);
    draw_height_labels(std::vector{label_at(60, 30, 0)}, up);
    draw_height_labels(std::vector{label_at(60, 30, std::numbers::pi_v<float>)}, down);
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 120; ++x)
            ASSERT_NEAR(up.pixel(x, y)[0], down.pixel(119 - x, 59 - y)[0], 1e-3) << x << " " << y;
}

TEST(HeightLabel, PartsOfAPictureGetTheirPartOfIt) {
    Picture whole = white(200, 150);
    const std::vector labels{label_at(90, 70, 0.8f), label_at(30, 120, -0.3f)};
    draw_height_labels(labels, whole);
    const PixelWindow window{60, 50, 50, 40};
    Picture part = white(window.width, window.height);
    draw_height_labels(labels, Canvas(part, window.x, window.y, 200, 150));
    EXPECT_EQ(part.rgba, crop(whole, window).rgba);
}

/// A slope with a contour line along its middle row, painted at `factor` times the picture's size.
Picture painted(int factor, std::span<const HeightLabel> labels, double spacing) {
    test::ReliefScene s(200 * factor, 60 * factor, [](double, double y) { return 0.05 * y; },
                        1.0 / factor);
    s.relief.spacing = spacing;
    ShadeView shade;
    shade.orthographic = true;
    return paint_relief(s.buffer, s.view, shade, {0, 60 * factor}, s.relief,
                        static_cast<float>(factor), labels, factor);
}

TEST(HeightLabel, ContourLinesLeaveAGapForIt) {
    const std::vector labels{label_at(100, 30, 0)};
    for (const int factor : {1, 2}) {
        const Picture with = painted(factor, labels, 100), without = painted(factor, {}, 100),
                      bare = painted(factor, labels, 0);
        const int y = 30 * factor;
        const auto value = [&](const Picture& p, float x) {
            return p.pixel(static_cast<int>(x * static_cast<float>(factor)), y)[0];
        };
        EXPECT_LT(value(without, 100), 0.8f * value(bare, 100));
        const float edge = labels[0].half_length();
        for (const float x : {100.0f, 100 - edge + 2, 100 + edge - 2})
            EXPECT_EQ(value(with, x), value(bare, x)) << x << " " << factor;
        for (const float x : {100 - edge - 2, 100 + edge + 2})
            EXPECT_EQ(value(with, x), value(without, x)) << x << " " << factor;
    }
}

}  // namespace
}  // namespace slim
