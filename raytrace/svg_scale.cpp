#include "raytrace/svg_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slim {

std::string svg_number(double value, int digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

SvgScale::SvgScale(double mm_per_pixel)
    : mm_per_pixel_(mm_per_pixel),
      digits_(3 + std::clamp(static_cast<int>(std::ceil(std::log10(kScreen / mm_per_pixel))), 0,
                             9)) {}

std::string SvgScale::opening(const PixelWindow& window) const {
    const auto from = [&](int px) { return px == 0 ? std::string("0") : mm(px); };
    const std::string w = mm(window.width), h = mm(window.height);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"" + w +
           "mm\" height=\"" + h + "mm\" viewBox=\"" + from(window.x) + " " + from(window.y) + " " +
           w + " " + h +
           "\" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n";
}

}  // namespace slim
