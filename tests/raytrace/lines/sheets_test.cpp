#include "raytrace/lines/sheets.h"

#include "raytrace/lines/sheet_blur.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim {
namespace {

/// A torus from above its rim, whose near side hides part of the far one;
/// no whole number of lanes wide.
class SheetsTest : public testing::Test {
protected:
    SheetsTest() {
        const auto model = test::torus_model(1, 0.35, 60, 24, 2);
        RenderRequest request;
        request.camera.eye = {3.5, 0, 1.2}, request.camera.up = {0, 0, 1};
        request.width = kWidth, request.height = kHeight;
        request.wanted = kPositionChannel | kNormalChannel, request.lod_px = 0;
        render_forward(model.view(), request, buffer_);
        view_ = pixel_view(request.camera, kWidth, kHeight);
    }
    LineScene scene() const { return {buffer_, view_, 3, 2}; }

    static constexpr int kWidth = 411, kHeight = 400;  // a reach of 1
    GBuffer buffer_;
    PixelView view_;
};

TEST_F(SheetsTest, SayOfEachPairWhatTheSceneSays) {
    const LineScene s = scene();
    const Sheets sheets(s);
    std::size_t joined = 0, broken = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (const bool down : {false, true}) {
                const std::size_t a = buffer_.index(x, y), b = a + (down ? kWidth : 1);
                const bool inside = down ? y + 1 < kHeight : x + 1 < kWidth;
                const bool hits = inside && s.hit(a) && s.hit(b);
                const SheetEdges& edges = sheets.to(down);
                const auto first = [&](const BitRows& bits) { return (bits.at(y, x) & 1) != 0; };
                ASSERT_EQ(first(edges.unbroken), hits && !breaks_off(s, a, b)) << x << ' ' << y;
                ASSERT_EQ(first(edges.joined), hits && one_sheet(s, a, b)) << x << ' ' << y;
                ASSERT_EQ(first(edges.creased), hits && !breaks_off(s, a, b) &&
                                                    dot(s.normal(a), s.normal(b)) < kCreaseTurn);
                ASSERT_EQ(
                    sheets.pairs(down, static_cast<std::size_t>(y), static_cast<std::size_t>(x)) &
                        1,
                    inside);
                joined += first(edges.joined), broken += hits && !first(edges.unbroken);
            }
    EXPECT_GT(joined, 30000u);
    EXPECT_GT(broken, 100u);
}

TEST_F(SheetsTest, BlurIsTheMeanAlongRowsThenColumns) {
    const LineScene s = scene();
    const Sheets sheets(s);
    ASSERT_EQ(sheets.reach, 1u);
    std::vector<float> plane(buffer_.n_pixels()), along(plane.size());
    for (std::size_t i = 0; i < plane.size(); ++i)
        plane[i] = s.hit(i) ? static_cast<float>(unit_interval(keyed_hash(1, i))) : std::nanf("");
    // Joined to the neighbour before and after, one pixel each.
    const auto mean = [&](const std::vector<float>& from, std::size_t i, std::size_t step,
                          bool before, bool after) {
        float sum = from[i], n = 1;
        if (after && one_sheet(s, i, i + step)) sum += from[i + step], ++n;
        if (before && one_sheet(s, i - step, i)) sum += from[i - step], ++n;
        return sum / n;
    };
    for (std::size_t i = 0; i < plane.size(); ++i)
        if (s.hit(i)) along[i] = mean(plane, i, 1, i % kWidth > 0, i % kWidth + 1 < kWidth);
    const std::vector<float> out = blurred(sheets, plane);
    for (std::size_t i = 0; i < plane.size(); ++i)
        if (s.hit(i)) {
            ASSERT_NEAR(out[i], mean(along, i, kWidth, i >= kWidth, i + kWidth < plane.size()),
                        1e-6f)
                << i;
        }
}

}  // namespace
}  // namespace slim
