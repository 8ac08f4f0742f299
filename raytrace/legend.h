#pragma once

#include "raytrace/canvas.h"
#include "raytrace/color_map.h"
#include "raytrace/legend_place.h"
#include "raytrace/picture.h"

#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// What a reader needs to turn a false colour back into a number.
struct Legend {
    std::string title;       ///< "mean curvature"
    std::string unit;        ///< "1/mm"; empty for pure numbers
    const ColorMap* map = nullptr;
    ValueRange range;        ///< the bar is linear in the values between its ends
    std::string high_note;   ///< above the bar: "convex +"; may be empty
    std::string low_note;    ///< below it: "concave \u2212"
    bool clipped_high = false, clipped_low = false;  ///< values beyond the range: arrow tips
};

/// Round values inside the range, ascending, 4 to 9 of them, 0 among them if it is inside; the ends
/// of a symmetric range are always ticks.
std::vector<double> legend_ticks(const ValueRange& range);

/// A tick's text with as many digits as its neighbours need; U+2212 for minus.
std::string tick_label(double value, const std::vector<double>& ticks);

/// The place where the panel covers the least of an object that stands over transparent (sum of
/// alpha) and of what else is taken. Where an upright one covers nothing: at the right, a corner
/// there, or the same at the left. Else below, which hides less, and a corner, are among the
/// places, the middle of a side last of those that are equal.
LegendPlace best_legend_place(const Legend& legend, const Picture& object,
                              const PixelBox& taken = {});

/// What the panel takes in a width x height picture.
PixelBox legend_box(const Legend& legend, LegendPlace place, int width, int height);

/// Burns the legend into a picture on a translucent panel, scaled with the smaller side (1000
/// pixels: digits 14 high). Where it takes less than 30 % of the width, the bar of an upright one
/// is as short as the height needs. Returns false and leaves the picture alone if it would take
/// more than 60 % of the width or, of more than 30 %, 75 % of the height.
bool burn_legend(const Legend& legend, const Canvas& canvas,
                 LegendPlace place = LegendPlace::right);

/// Share of the width of a width x height picture that the panel and its margin take; 0 where
/// burn_legend would refuse.
double legend_share(const Legend& legend, int width, int height);

/// The same bar as a file of its own: SVG 1.1, millimetres, for print.
std::string legend_svg(const Legend& legend);

}  // namespace slim
