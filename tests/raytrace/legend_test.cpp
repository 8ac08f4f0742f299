#include "raytrace/legend.h"

#include "tests/raytrace/support/ink.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

namespace slim {
namespace {

using test::n_different;
using test::n_inked;
using test::white;

Legend mean_legend() {
    return {"mean curvature", "1/mm", &cool_warm(), {-2, 2}, "convex +", "concave \u2212"};
}

Picture burnt(const Legend& legend, int width = 1000, int height = 1000) {
    Picture p = white(width, height);
    EXPECT_TRUE(burn_legend(legend, p));
    return p;
}

TEST(Legend, TicksOfASymmetricRangeAreItsEndsHalvesAndZero) {
    EXPECT_EQ(legend_ticks({-3, 3}), (std::vector<double>{-3, -1.5, 0, 1.5, 3}));
}

TEST(Legend, TicksOfAnyRangeAreRoundInsideAndFew) {
    for (const ValueRange r : {ValueRange{0, 1}, {4.38, 6.47}, {0, 8e-5}, {-1, 3}, {99, 99.5}}) {
        const auto ticks = legend_ticks(r);
        EXPECT_GE(ticks.size(), 4u) << r.hi;
        EXPECT_LE(ticks.size(), 9u) << r.hi;
        const double step = ticks[1] - ticks[0];
        for (const double t : ticks) {
            EXPECT_GE(t, r.lo - 1e-9 * step);
            EXPECT_LE(t, r.hi + 1e-5 * step);
            EXPECT_NEAR(std::remainder(t, step), 0, 1e-6 * step);
        }
    }
}

TEST(Legend, LabelsHaveTheDigitsTheirNeighboursNeed) {
    const std::vector<double> halves{-2.5, -1.25, 0, 1.25, 2.5};
    EXPECT_EQ(tick_label(2.5, halves), "2.50");
    EXPECT_EQ(tick_label(-1.25, halves), "\u22121.25");
    EXPECT_EQ(tick_label(0, halves), "0");
    EXPECT_EQ(tick_label(100, {0, 50, 100}), "100");
    EXPECT_EQ(tick_label(1.5e-5, {0, 1.5e-5, 3e-5}), "1.5e\u22125");
    EXPECT_EQ(tick_label(2e7, {0, 1e7, 2e7}), "2e7");
}

TEST(Legend, BarShowsTheMapFromTopToBottom) {
    const Picture p = burnt(mean_legend());
    // Somewhere in the picture the ends of the map are painted, the warm one above the cool one.
    int warm = -1, cool = -1;
    const Vec3f top = cool_warm().linear(1), bottom = cool_warm().linear(0);
    for (int y = 0; y < p.height; ++y)
        for (int x = 0; x < p.width; ++x) {
            const float* c = p.pixel(x, y);
            if (warm < 0 && std::abs(c[0] - top.x) + std::abs(c[2] - top.z) < 0.02f) warm = y;
            if (std::abs(c[0] - bottom.x) + std::abs(c[2] - bottom.z) < 0.02f) cool = y;
        }
    ASSERT_GE(warm, 0);
    EXPECT_NEAR(cool - warm, 330, 12);  // the bar is a third of the picture
}

TEST(Legend, EveryFieldShows) {
    const Picture base = burnt(mean_legend());
    const auto changed = [&](auto change) {
        Legend legend = mean_legend();
        change(legend);
        return n_different(base, burnt(legend)) > 20;
    };
    EXPECT_TRUE(changed([](Legend& l) { l.title = "Gauss curvature"; }));
    EXPECT_TRUE(changed([](Legend& l) { l.unit = "1/km"; }));
    EXPECT_TRUE(changed([](Legend& l) { l.map = &viridis(); }));
    EXPECT_TRUE(changed([](Legend& l) { l.range = {-3, 3}; }));
    EXPECT_TRUE(changed([](Legend& l) { l.high_note = "outside"; }));
    EXPECT_TRUE(changed([](Legend& l) { l.low_note = "inside"; }));
    EXPECT_TRUE(changed([](Legend& l) { l.clipped_high = true; }));
    EXPECT_TRUE(changed([](Legend& l) { l.clipped_low = true; }));
}

TEST(Legend, GrowsWithThePicture) {
    const double ratio = static_cast<double>(n_inked(burnt(mean_legend(), 2000, 2000))) /
                         n_inked(burnt(mean_legend()));
    EXPECT_NEAR(ratio, 4, 0.5);
}

TEST(Legend, IsLeftOutWhereItWouldHideThePicture) {
    Picture p = white(160, 120);
    EXPECT_FALSE(burn_legend(mean_legend(), p));
    EXPECT_EQ(n_inked(p), 0);
}

/// Rows of a picture from the first to the last with ink, and the runs of rows among them with some
/// of the numbers' columns (of an upright legend at the right).
struct InkedRows {
    int first = -1, last = -1, n_numbers = 0;

    InkedRows(const Picture& p, int numbers_from) {
        bool was_number = false;
        for (int y = 0; y < p.height; ++y) {
            bool ink = false, number = false;
            for (int x = 0; x < p.width; ++x)
                if (p.pixel(x, y)[0] < 0.5f) ink = true, number = number || x >= numbers_from;
            if (ink) last = y, first = first < 0 ? y : first;
            n_numbers += number && !was_number;
            was_number = number;
        }
    }
};

TEST(Legend, LowPicturesHaveAShorterBarBesideWhichThereIsRoom) {
    Legend legend = mean_legend();
    legend.clipped_high = legend.clipped_low = true;
    for (const auto& [width, height] :
         {std::pair{1000, 300}, {1000, 360}, {500, 300}, {640, 200}}) {
        SCOPED_TRACE(height);
        Picture p = white(width, height);
        ASSERT_TRUE(burn_legend(legend, p));
        EXPECT_GT(legend_share(legend, width, height), 0);
        const PixelBox box = legend_box(legend, LegendPlace::right, width, height);
        EXPECT_GE(box.y0, 12);
        EXPECT_LE(box.y1, height - 12);
        const InkedRows rows(p, width);
        EXPECT_GE(rows.first, static_cast<int>(box.y0));
        EXPECT_LT(rows.last, static_cast<int>(box.y1));
    }
    Picture narrow = white(250, 250);
    EXPECT_FALSE(burn_legend(legend, narrow));
}

TEST(Legend, NumbersOfAShortBarStandApart) {
    const Legend legend = mean_legend();
    Picture p = white(640, 170);
    ASSERT_TRUE(burn_legend(legend, p));
    const PixelBox box = legend_box(legend, LegendPlace::right, 640, 170);
    const int numbers = static_cast<int>(box.x0) + 9 + 15 + 4 + 3;  // padding, bar, tick, gap
    const InkedRows few(p, numbers);
    Picture large = white(1000, 1000);
    ASSERT_TRUE(burn_legend(legend, large));
    const PixelBox usual = legend_box(legend, LegendPlace::right, 1000, 1000);
    const InkedRows all(large, static_cast<int>(usual.x0) + 18 + 30 + 7 + 6);
    EXPECT_GE(few.n_numbers, 5);  // title, unit, notes and numbers
    EXPECT_LE(few.n_numbers, all.n_numbers);
}

/// A full picture but for one rectangle that is clear.
Picture covered_but(int x0, int y0, int x1, int y1) {
    Picture p = white(1000, 1000);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) p.pixel(x, y)[3] = 0;
    return p;
}

TEST(Legend, StandsWhereItCoversLeast) {
    const auto place = [](const Picture& p) { return best_legend_place(mean_legend(), p); };
    EXPECT_EQ(place(Picture(1000, 1000)), LegendPlace::right);
    EXPECT_EQ(place(white(1000, 1000)), LegendPlace::below);  // the smaller panel, at the edge
    const Picture narrow = white(150, 1000);  // for that
    EXPECT_LT(legend_box(mean_legend(), LegendPlace::below, 150, 1000).x0, 0);
    EXPECT_EQ(place(narrow), LegendPlace::right_bottom);  // not over the middle
    EXPECT_EQ(place(covered_but(700, 0, 1000, 550)), LegendPlace::right_top);
    EXPECT_EQ(place(covered_but(700, 450, 1000, 1000)), LegendPlace::right_bottom);
    EXPECT_EQ(place(covered_but(0, 200, 300, 800)), LegendPlace::left);
    EXPECT_EQ(place(covered_but(0, 0, 300, 550)), LegendPlace::left_top);
    EXPECT_EQ(place(covered_but(0, 450, 300, 1000)), LegendPlace::left_bottom);
}

TEST(Legend, IsBurntWhereItWasSaidToStand) {
    for (const LegendPlace place : {LegendPlace::left_top, LegendPlace::right_bottom}) {
        Picture p(1000, 1000);
        ASSERT_TRUE(burn_legend(mean_legend(), p, place));
        double x_sum = 0, y_sum = 0, n = 0;
        for (int y = 0; y < 1000; ++y)
            for (int x = 0; x < 1000; ++x)
                if (p.pixel(x, y)[3] > 0) x_sum += x, y_sum += y, ++n;
        EXPECT_EQ(x_sum / n < 500, place == LegendPlace::left_top);
        EXPECT_EQ(y_sum / n < 500, place == LegendPlace::left_top);
    }
}

TEST(Legend, ShareIsWhatThePanelTakes) {
    Picture p(1000, 1000);
    ASSERT_TRUE(burn_legend(mean_legend(), p));
    int first = 1000;
    for (int x = 999; x >= 0; --x)
        if (p.pixel(x, 500)[3] > 0) first = x;
    EXPECT_NEAR(legend_share(mean_legend(), 1000, 1000), (1000 - first) / 1000.0, 0.002);
    EXPECT_EQ(legend_share(mean_legend(), 160, 120), 0);
}

/// The first and the last column in which something of a row is not white.
std::pair<int, int> columns_of_row(const Picture& p, int y) {
    int first = p.width, last = -1;
    for (int x = 0; x < p.width; ++x)
        if (p.pixel(x, y)[0] + p.pixel(x, y)[1] + p.pixel(x, y)[2] < 2.9f)
            first = std::min(first, x), last = std::max(last, x);
    return {first, last};
}

TEST(Legend, BelowItsBarLiesAlongTheEdgeFromLowToHigh) {
    Legend legend = mean_legend();
    legend.clipped_high = true;
    Picture p = white(1000, 1000);
    ASSERT_TRUE(burn_legend(legend, p, LegendPlace::below));
    const PixelBox box = legend_box(legend, LegendPlace::below, 1000, 1000);
    EXPECT_GT(box.y0, 800);  // lower than the upright one is high
    for (int y = 0; y < 1000; ++y) {
        const auto [left, right] = columns_of_row(p, y);
        if (right < 0) continue;
        EXPECT_TRUE(left >= static_cast<int>(box.x0) && right < static_cast<int>(box.x1) &&
                    y >= static_cast<int>(box.y0) && y < static_cast<int>(box.y1));
    }
    const int bar = static_cast<int>(box.y1) - 18 - 14 - 8 - 7 - 12;  // numbers and ticks below it
    const auto [first, last] = columns_of_row(p, bar);
    EXPECT_NEAR(last - first, 330 + 15, 6);  // and a tip at the right
    EXPECT_GT(p.pixel(first + 8, bar)[2], p.pixel(first + 8, bar)[0] + 0.3f);  // concave is blue
    EXPECT_GT(p.pixel(last - 18, bar)[0], p.pixel(last - 18, bar)[2] + 0.3f);
}

TEST(Legend, BelowNumbersStandApart) {
    Legend legend = mean_legend();
    legend.range = {-12.5, 2500};
    for (const bool wide : {false, true}) {
        legend.range.hi = wide ? 2500000 : 2500;
        Picture p = white(1000, 1000);
        ASSERT_TRUE(burn_legend(legend, p, LegendPlace::below));
        const PixelBox box = legend_box(legend, LegendPlace::below, 1000, 1000);
        // Between two numbers lies a gap: count the runs of columns with ink, letters apart at most
        // by 6 pixels.
        int runs = 0, since = 100;
        for (int x = static_cast<int>(box.x0); x < static_cast<int>(box.x1); ++x) {
            bool ink = false;
            for (int y = static_cast<int>(box.y1) - 34; y < static_cast<int>(box.y1) - 18; ++y)
                ink = ink || p.pixel(x, y)[0] < 0.5f;
            if (ink && since > 6) ++runs;
            since = ink ? 0 : since + 1;
        }
        EXPECT_GE(runs, 3) << wide;
        EXPECT_LE(runs, 9) << wide;
    }
}

TEST(Legend, StandsBelowWhereOnlyThatIsFree) {
    Picture object(1000, 1000);
    for (int y = 0; y < 800; ++y)
        for (int x = 0; x < 1000; ++x) object.pixel(x, y)[3] = 1;
    EXPECT_EQ(best_legend_place(mean_legend(), object), LegendPlace::below);
    // It may not lie on what else is there.
    EXPECT_NE(best_legend_place(mean_legend(), Picture(1000, 1000), {700, 0, 1000, 1000}),
              LegendPlace::right);
    EXPECT_EQ(best_legend_place(mean_legend(), Picture(1000, 1000)), LegendPlace::right);
}

TEST(Legend, SvgNamesAllAndEscapes) {
    Legend legend = mean_legend();
    legend.unit = "1/<b>&";
    const std::string svg = legend_svg(legend);
    for (const char* text : {"<svg", "mean curvature", "1/&lt;b&gt;&amp;", "convex +",
                             "concave \u2212", "#3b4cc0", "#b40426", ">\u22122<", ">1<", "mm\""})
        EXPECT_NE(svg.find(text), std::string::npos) << text;
    EXPECT_EQ(svg.find(" Z\" fill"), std::string::npos);
    legend.clipped_high = true;
    EXPECT_NE(legend_svg(legend).find(" Z\" fill"), std::string::npos);
}

TEST(Legend, SvgIsAsWideAsItsWordsNeed) {
    Legend legend = mean_legend();
    EXPECT_NE(legend_svg(legend).find("width=\"44mm\""), std::string::npos);
    legend.unit = "1/US survey feet (1927)";  // 41.5 mm in DejaVu Sans, and 4 to its left
    const std::string svg = legend_svg(legend);
    const double width = std::stod(svg.substr(svg.find("width=\"") + 7));
    EXPECT_GT(width, 46);
    EXPECT_LT(width, 60);
    EXPECT_NE(svg.find("viewBox=\"0 0 " + std::to_string(static_cast<int>(width)) + " "),
              std::string::npos);
}

TEST(Legend, TheBarHasTheColoursOfItsValuesWhereTheSidesDifferInScale) {
    Legend legend = mean_legend();
    legend.range = {-10, 300, true};
    Picture p = white(1000, 1000);
    ASSERT_TRUE(burn_legend(legend, p));
    // The neutral colour is found where the tick of 0 is:
    // a thirtieth of the bar above its lower end.
    int first = 1000, last = 0, neutral = 0;
    const int x = [&] {
        for (int u = 999; u > 0; --u)
            for (int v = 0; v < 1000; ++v)
                if (p.pixel(u, v)[0] > p.pixel(u, v)[2] + 0.3f) return u - 5;
        return 0;
    }();
    for (int y = 0; y < 1000; ++y) {
        const float *c = p.pixel(x, y), spread = std::abs(c[0] - c[2]);
        const bool blue = c[2] > c[0] + 0.02f, red = c[0] > c[2] + 0.02f;
        if (!blue && !red) continue;
        first = std::min(first, y), last = std::max(last, y);
        if (blue && spread > 0.02f) neutral = neutral ? neutral : y;  // the first that is blue
    }
    EXPECT_NEAR(last - first, 330, 12);
    EXPECT_NEAR(last - neutral, 330.0 * 10 / 310, 4);
    // The SVG has a stop there, of the neutral colour.
    const std::string svg = legend_svg(legend);
    const std::size_t stop = svg.find("offset=\"0.0322581\" stop-color=\"#dd");
    EXPECT_NE(stop, std::string::npos) << svg;
    EXPECT_NE(svg.find(">0<"), std::string::npos);
}

}  // namespace
}  // namespace slim
