#include "pipeline/render/render_bands.h"

#include <algorithm>

namespace slim {
namespace {

/// Of the finished picture: enough work for all threads, little memory.
constexpr int kBandRows = 128;

}  // namespace

Picture paint_in_bands(const PictureSize& frame, const PictureSize& size, const RowPainter& paint) {
    const int factor = frame.width / size.width;
    if (factor == 1) return paint({0, size.height});
    if (size.height <= kBandRows) return box_downsample(paint({0, frame.height}), factor);
    Picture out(size.width, size.height);
    for (int y = 0; y < size.height; y += kBandRows) {
        const int end = std::min(size.height, y + kBandRows);
        const Picture band = box_downsample(paint({y * factor, end * factor}), factor);
        std::copy(band.rgba.begin(), band.rgba.end(), out.pixel(0, y));
    }
    return out;
}

}  // namespace slim
