#pragma once

#include "raytrace/canvas.h"
#include "slim/base/vec.h"

#include <algorithm>
#include <cmath>

namespace slim {

inline constexpr Vec3f kInk{0.012f, 0.013f, 0.016f};  ///< text and strokes, linear Rec.709

/// A rectangle in pixels of the whole picture.
struct PixelBox {
    float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Mixes a colour into a pixel by its share of cover.
inline void blend_pixel(float* p, const Vec3f& color, float coverage) {
    p[0] += (color.x - p[0]) * coverage, p[1] += (color.y - p[1]) * coverage;
    p[2] += (color.z - p[2]) * coverage, p[3] += (1 - p[3]) * coverage;
}

/// Calls pixel(x, y, p) at the centres of the canvas's pixels that the box touches.
template <class Body>
void for_pixels(const Canvas& canvas, const PixelBox& box, const Body& pixel) {
    const int from_x = std::max(canvas.x0, static_cast<int>(std::floor(box.x0)));
    const int from_y = std::max(canvas.y0, static_cast<int>(std::floor(box.y0)));
    const int to_x = std::min(canvas.x_end(), static_cast<int>(std::ceil(box.x1)));
    const int to_y = std::min(canvas.y_end(), static_cast<int>(std::ceil(box.y1)));
    for (int y = from_y; y < to_y; ++y)
        for (int x = from_x; x < to_x; ++x)
            pixel(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, canvas.pixel(x, y));
}

/// A translucent sheet of white with round corners, for words over a picture.
void fill_panel(const Canvas& canvas, const PixelBox& box, float radius);

/// A box with smooth edges.
void fill_box(const Canvas& canvas, const PixelBox& box, const Vec3f& color);

/// A thousandth of the picture's smaller side, at least half a pixel: the unit of all that is
/// written on it.
float text_unit(int width, int height);

}  // namespace slim
