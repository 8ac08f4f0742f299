#pragma once

#include <string>
#include <vector>

namespace slim {

/// One curve of a plot.
struct SvgCurve {
    struct Point {
        double x, y;
        bool broken = false;  ///< drawn as a cross
    };
    std::string name;
    std::vector<Point> points;  ///< joined in this order; those that a
                                ///< logarithm has no place for are left out
    /// A dashed line of this slope (of the logarithms) through the curve's middle; NaN: none.
    double guide_slope = 0;
    bool has_guide = false;
};

struct SvgPlot {
    std::string x_label, y_label;
    bool log_x = true, log_y = true;
    std::vector<SvgCurve> curves;
};

/// The plot as an SVG element of 640 by 400, to stand in an HTML page: axes with ticks at round
/// numbers, curves with marks, a legend; text as text. Eight colours that colour-blind readers tell
/// apart (Okabe and Ito 2008), marks differ too.
std::string svg_of(const SvgPlot& plot);

}  // namespace slim
