#include "raytrace/lines/link.h"

#include "raytrace/lines/select.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace slim {
namespace {

/// A wall across the view, on which any function of the pixel can be drawn.
class LinkTest : public testing::Test {
protected:
    LinkTest() {
        camera_.eye = {0, 0, 10}, camera_.target = {0, 0, 0};
        camera_.orthographic = true, camera_.width = kSize;
        view_ = pixel_view(camera_, kSize, kSize);
        buffer_.reset(kSize, kSize, kPositionChannel | kNormalChannel);
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) put(x, y, 0);
    }
    void put(int x, int y, float z) {
        const std::size_t i = buffer_.index(x, y);
        buffer_.hit[i] = 1;
        buffer_.position[0][i] = static_cast<float>(x),
        buffer_.position[1][i] = static_cast<float>(-y);
        buffer_.position[2][i] = z, buffer_.normal[2][i] = 1;
    }
    LineScene scene() const { return {buffer_, view_, 50, 2}; }

    /// Zeros of f at the pixels' centres.
    template <class F>
    std::vector<FeatureLine> zeros(const F& f) {
        const LineScene s = scene();
        const auto at = [&](std::size_t i) {
            return f(static_cast<float>(i % kSize) + 0.5f, static_cast<float>(i / kSize) + 0.5f);
        };
        const auto field = find_on_sheets(
            s, Sheets(s), [&](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
                const float fa = at(a), fb = at(b);
                if ((fa > 0) == (fb > 0)) return std::nullopt;
                return EdgeHit{fa / (fa - fb), 1};
            });
        return link_crossings(s, field, LineKind::parabolic);
    }

    static constexpr int kSize = 64;
    Camera camera_;
    PixelView view_;
    GBuffer buffer_;
};

TEST_F(LinkTest, ACircleIsOneLoop) {
    auto lines = zeros([](float x, float y) { return std::hypot(x - 30, y - 33) - 20; });
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].closed);
    measure_line(lines[0]);
    EXPECT_NEAR(lines[0].length_px, 2 * std::numbers::pi * 20, 0.5);
    EXPECT_NEAR(lines[0].length, 2 * std::numbers::pi * 20, 0.5);
    smooth_line(lines[0], 4);
    for (const LinePoint& p : lines[0].points) EXPECT_NEAR(std::hypot(p.x - 30, p.y - 33), 20, 0.1);
}

TEST_F(LinkTest, TwoCirclesAreTwoLoopsAndALineIsOpen) {
    EXPECT_EQ(zeros([](float x, float y) {
                  return std::fmin(std::hypot(x - 16, y - 30), std::hypot(x - 46, y - 30)) - 10;
              }).size(),
              2u);
    const auto lines = zeros([](float x, float y) { return y - 20 - 0.3f * x; });
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_FALSE(lines[0].closed);
}

TEST_F(LinkTest, ASaddleInACellGivesTwoLines) {
    // x y = small: a hyperbola whose branches pass through the same cell.
    const auto lines = zeros([](float x, float y) { return (x - 32.1f) * (y - 32.1f) - 0.001f; });
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_FALSE(lines[0].closed || lines[1].closed);
}

TEST_F(LinkTest, LinesEndAtAStepToAnotherSheet) {
    for (int y = 0; y < kSize; ++y)
        for (int x = kSize / 2; x < kSize; ++x) put(x, y, 5);
    const auto lines = zeros([](float, float y) { return y - 20; });
    ASSERT_EQ(lines.size(), 2u);
    for (const FeatureLine& line : lines)
        for (std::size_t i = 1; i < line.points.size(); ++i)
            EXPECT_EQ(line.points[i].point.z, line.points[0].point.z);
}

TEST_F(LinkTest, AStepIsAContour) {
    for (int y = 10; y < 30; ++y)
        for (int x = 20; x < 40; ++x) put(x, y, 5);
    const LineScene s = scene();
    auto lines = select_lines(link_crossings(s, contour_crossings(s, Sheets(s)), LineKind::contour),
                              line_rules(LineKind::contour, kSize, kSize));
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].closed);
    EXPECT_NEAR(lines[0].length_px, 80, 4);
    for (const LinePoint& p : lines[0].points) EXPECT_EQ(p.point.z, 5);  // of the nearer sheet
}

}  // namespace
}  // namespace slim
