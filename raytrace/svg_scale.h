#pragma once

#include "raytrace/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace slim {

/// A number with so many digits after the point.
inline std::string svg_number(double value, int digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

/// What a pixel of a picture is in a drawing.
struct SvgScale {
    static constexpr double kScreen = 25.4 / 96;  ///< as in browsers

    double mm_per_pixel = kScreen;

    /// Pixels in millimetres, to a thousandth, or to as small a part of a smaller pixel.
    std::string mm(double px) const {
        const double finer = std::log10(kScreen / mm_per_pixel);
        return svg_number(mm_per_pixel * px, 3 + std::clamp(static_cast<int>(std::ceil(finer)),
                                                            0, 9));
    }
    std::string mm(float px) const { return mm(static_cast<double>(px)); }

    /// Opens a drawing in millimetres of the whole picture that shows the window, nothing filled
    /// and strokes with round ends.
    std::string opening(const PixelWindow& window) const {
        const auto from = [&](int px) { return px == 0 ? std::string("0") : mm(static_cast<double>(px)); };
        const std::string w = mm(static_cast<double>(window.width)), h = mm(static_cast<double>(window.height));
        return "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"" + w +
               "mm\" height=\"" + h + "mm\" viewBox=\"" + from(window.x) + " " +
               from(window.y) + " " + w + " " + h +
               "\" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n";
    }
};

}  // namespace slim
