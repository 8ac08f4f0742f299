#include "raytrace/crop.h"
#include "raytrace/key.h"
#include "raytrace/scale_bar.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace slim {
namespace {

TEST(ScaleBar, LengthIsRoundAndTakesAFairShare) {
    for (const double px_per_unit : {0.003, 0.7, 1.0, 13.0, 4711.0}) {
        const double share = scale_bar_length({px_per_unit, ""}, 1000) * px_per_unit / 1000;
        EXPECT_GT(share, 0.11) << px_per_unit;
        EXPECT_LE(share, 0.3) << px_per_unit;
    }
    EXPECT_DOUBLE_EQ(scale_bar_length({1, ""}, 1000), 200);
}

TEST(ScaleBar, PartsOfAPictureGetTheirPartOfIt) {
    Picture whole(700, 500);
    ASSERT_TRUE(burn_scale_bar({2.5, "mm"}, whole));
    const PixelWindow window{20, 371, 150, 100};
    Picture part(window.width, window.height);
    ASSERT_TRUE(burn_scale_bar({2.5, "mm"}, Canvas(part, window.x, window.y, 700, 500)));
    EXPECT_EQ(part.rgba, crop(whole, window).rgba);
    EXPECT_GT(*std::max_element(part.rgba.begin(), part.rgba.end()), 0.5f);
    Picture tiny(60, 40);
    EXPECT_FALSE(burn_scale_bar({2.5, "mm"}, tiny));
}

TEST(ScaleBar, StandsInTheCornerWanted) {
    for (const LegendPlace corner : {LegendPlace::left_bottom, LegendPlace::right_bottom,
                                     LegendPlace::left_top, LegendPlace::right_top}) {
        const PixelBox box = scale_bar_box({2.5, "mm"}, 700, 500, corner);
        EXPECT_EQ(box.x0 < 350, is_left(corner));
        EXPECT_EQ(box.y0 < 250, is_top(corner));
        EXPECT_GE(std::min({box.x0, box.y0, 700 - box.x1, 500 - box.y1}), 12);  // the margin
        Picture whole(700, 500);
        ASSERT_TRUE(burn_scale_bar({2.5, "mm"}, whole, corner));
        EXPECT_GT(whole.pixel(static_cast<int>((box.x0 + box.x1) / 2),
                              static_cast<int>(box.y0) + 3)[3], 0.5f);
    }
}

TEST(Key, StandsWhereItHidesLeastAndIsWrittenAsSvg) {
    const Key key{"title", {{"red <x>", true, {1, 0, 0}}, {"plain", false, {}}}};
    Picture object(800, 600);
    for (int y = 300; y < 600; ++y)
        for (int x = 400; x < 800; ++x) object.pixel(x, y)[3] = 1;
    EXPECT_EQ(best_key_place(key, object), LegendPlace::right_top);
    ASSERT_TRUE(burn_key(key, object, LegendPlace::right_top));
    EXPECT_NE(key_svg(key).find("red &lt;x&gt;"), std::string::npos);
    EXPECT_NE(key_svg(key).find("#ff0000"), std::string::npos);
}

TEST(Key, SvgIsAsWideAsItsWordsNeed) {
    const Key key{"contour lines", {{"every 5 m", false, {}}}};
    EXPECT_NE(key_svg(key).find("width=\"70mm\" height=\"18mm\" viewBox=\"0 0 70 18\""),
              std::string::npos);
    const std::string svg =
        key_svg({"contour lines", {{"heavy every 0.025 US survey feet (1927)", false, {}}}});
    const double width = std::stod(svg.substr(svg.find("width=\"") + 7));
    EXPECT_GT(width, 74);  // 69.9 mm in DejaVu Sans, and 4 to its left
    EXPECT_LT(width, 90);
}

}  // namespace
}  // namespace slim
