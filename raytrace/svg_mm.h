#pragma once

#include "raytrace/renderer.h"

#include <cstdio>
#include <string>

namespace slim {

inline constexpr double kMmPerPixel = 25.4 / 96;  ///< as in browsers

/// A number with so many digits after the point.
inline std::string svg_number(double value, int digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

/// Pixels of a picture in millimetres, to a thousandth.
inline std::string svg_mm(double px) { return svg_number(kMmPerPixel * px, 3); }

/// Opens a drawing in millimetres of the whole picture that shows the window, nothing filled and
/// strokes with round ends.
inline std::string svg_opening(const PixelWindow& window) {
    const auto from = [](int px) { return px == 0 ? std::string("0") : svg_mm(px); };
    const std::string w = svg_mm(window.width), h = svg_mm(window.height);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"" + w +
           "mm\" height=\"" + h + "mm\" viewBox=\"" + from(window.x) + " " + from(window.y) + " " +
           w + " " + h +
           "\" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n";
}

}  // namespace slim
