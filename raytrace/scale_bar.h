#pragma once

#include "raytrace/canvas.h"
#include "raytrace/legend_place.h"
#include "raytrace/panel.h"

#include <string>

namespace slim {

/// The scale of an orthographic picture: pixels a model unit.
struct ScaleBar {
    double px_per_unit = 1;
    std::string unit;  ///< empty: "units"
};

/// Length of the form {1, 2, 5} * 10^k, in model units, of a bar that takes 12 to 30 % of the
/// picture's width.
double scale_bar_length(const ScaleBar& scale, int width);

/// What bar and words take in a corner of a width x height picture; nothing where they have no
/// room.
PixelBox scale_bar_box(const ScaleBar& scale, int width, int height,
                       LegendPlace corner = LegendPlace::left_bottom);

/// Where the right end of the widest one is.
float scale_bar_most(int width, int height);

/// Draws bar, its length and the size of a pixel on a panel in a corner, in the legend's style.
/// Returns false and leaves the picture alone if that would take more than 60 % of the width or
/// 40 % of the height.
bool burn_scale_bar(const ScaleBar& scale, const Canvas& canvas,
                    LegendPlace corner = LegendPlace::left_bottom);

/// Share of the height of a width x height picture that the panel and its margin take at the
/// bottom.
double scale_bar_share(int width, int height);

}  // namespace slim
