#include "raytrace/legend_place.h"

#include <algorithm>

namespace slim {

double covered_alpha(const PixelBox& box, const Picture& object) {
    const int from_x = std::max(0, static_cast<int>(box.x0)),
              from_y = std::max(0, static_cast<int>(box.y0));
    const int to_x = std::min(object.width, static_cast<int>(box.x1));
    const int to_y = std::min(object.height, static_cast<int>(box.y1));
    double sum = 0;
    for (int y = from_y; y < to_y; ++y)
        for (int x = from_x; x < to_x; ++x) sum += static_cast<double>(object.pixel(x, y)[3]);
    return sum;
}

double shared_area(const PixelBox& a, const PixelBox& b) {
    const float w = std::min(a.x1, b.x1) - std::max(a.x0, b.x0);
    const float h = std::min(a.y1, b.y1) - std::max(a.y0, b.y0);
    return w > 0 && h > 0 ? static_cast<double>(w) * static_cast<double>(h) : 0;
}

double hidden_by(const PixelBox& box, const Picture& object, const PixelBox& taken) {
    const double pixels = static_cast<double>(object.width) * object.height;
    return covered_alpha(box, object) + pixels * shared_area(box, taken);
}

}  // namespace slim
