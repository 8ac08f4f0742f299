#pragma once

#include "raytrace/picture.h"

namespace slim {

/// A part of a picture that is drawn on in the coordinates of the whole, so that a crop or a band
/// gets the very bytes that the whole would have there.
struct Canvas {
    Picture& part;
    int x0 = 0, y0 = 0;         ///< where the part begins in the whole
    int width = 0, height = 0;  ///< of the whole

    Canvas(Picture& whole) : part(whole), width(whole.width), height(whole.height) {}
    Canvas(Picture& a_part, int at_x, int at_y, int whole_width, int whole_height)
        : part(a_part), x0(at_x), y0(at_y), width(whole_width), height(whole_height) {}

    int x_end() const { return x0 + part.width; }
    int y_end() const { return y0 + part.height; }
    float* pixel(int x, int y) const { return part.pixel(x - x0, y - y0); }
};

}  // namespace slim
