#pragma once

#include "raytrace/renderer.h"

#include <string>

namespace slim {

/// A number with so many digits after the point.
std::string svg_number(double value, int digits);

/// How large a pixel of a picture is in a drawing.
class SvgScale {
public:
    static constexpr double kScreen = 25.4 / 96;  ///< mm a pixel, as in browsers

    explicit SvgScale(double mm_per_pixel = kScreen);

    /// Pixels in millimetres, to a thousandth, or to as small a part of a smaller pixel.
    std::string mm(double px) const { return svg_number(mm_per_pixel_ * px, digits_); }
    std::string mm(float px) const { return mm(static_cast<double>(px)); }
    std::string mm(int px) const { return mm(static_cast<double>(px)); }

    /// Opens a drawing in millimetres of the whole picture that shows the window, nothing filled
    /// and strokes with round ends.
    std::string opening(const PixelWindow& window) const;

private:
    double mm_per_pixel_;
    int digits_;
};

}  // namespace slim
