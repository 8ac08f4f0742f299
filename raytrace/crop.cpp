#include "raytrace/crop.h"

#include "slim/base/check.h"

#include <algorithm>
#include <utility>

namespace slim {
namespace {

void check_inside(const PixelWindow& w, int width, int height) {
    SLIM_CHECK(w.x, >=, 0);
    SLIM_CHECK(w.y, >=, 0);
    SLIM_CHECK(w.x + w.width, <=, width);
    SLIM_CHECK(w.y + w.height, <=, height);
}

/// Entries of `size` values a pixel; an empty plane stays empty.
template <class T>
std::vector<T> part_of(const std::vector<T>& plane, int width, const PixelWindow& w,
                       std::size_t size) {
    if (plane.empty()) return {};
    const std::size_t row = size * static_cast<std::size_t>(w.width);
    std::vector<T> out(row * static_cast<std::size_t>(w.height));
    for (int y = 0; y < w.height; ++y) {
        const std::size_t from =
            size * (static_cast<std::size_t>(w.y + y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(w.x));
        std::copy_n(&plane[from], row, &out[row * static_cast<std::size_t>(y)]);
    }
    return out;
}

}  // namespace

Picture crop(Picture picture, const PixelWindow& w) {
    check_inside(w, picture.width, picture.height);
    if (w.width == picture.width && w.height == picture.height) return picture;
    Picture out;
    out.width = w.width, out.height = w.height;
    out.rgba = part_of(picture.rgba, picture.width, w, 4);
    return out;
}

GBuffer crop(const GBuffer& buffer, const PixelWindow& w) {
    check_inside(w, buffer.width, buffer.height);
    GBuffer out = buffer;
    out.width = w.width, out.height = w.height;
    out.hit = part_of(out.hit, buffer.width, w, 1);
    out.for_each_plane([&](auto& plane) { plane = part_of(plane, buffer.width, w, 1); });
    return out;
}

std::vector<float> crop(const std::vector<float>& plane, int width, const PixelWindow& w) {
    return part_of(plane, width, w, 1);
}

}  // namespace slim
