#pragma once

#include "pipeline/render/render_config.h"
#include "pipeline/render/render_view.h"
#include "raytrace/renderer.h"

#include <cstdint>
#include <vector>

namespace slim {

/// What of the picture is wanted: --crop or --tile of it, else the whole. ConfigError if both are
/// given, are not of their form, or lie outside.
PixelWindow wanted_window(const RenderConfig& config, const PictureSize& size);

/// A band of the wanted window that is drawn at once.
struct PicturePart {
    PixelWindow wanted;  ///< in pixels of the whole picture
    /// what is drawn for it: as much more as shading looks at, in whole tiles, inside the picture
    PixelWindow drawn;
    /// `wanted` in pixels of `drawn`
    PixelWindow inside() const {
        return {wanted.x - drawn.x, wanted.y - drawn.y, wanted.width, wanted.height};
    }
};

/// How far, in pixels, what is drawn for a part reaches beyond it for the sake of shading.
int shading_margin(const PictureSize& size);

/// What is drawn for a window: itself and a margin, in whole tiles, inside the picture.
PixelWindow drawn_window(const PixelWindow& wanted, const PictureSize& size, int margin);

/// Cuts the window into bands that take at most about 384 MiB without their margins, by the bytes
/// of a pixel. Where it is cut changes no byte of the picture.
std::vector<PicturePart> picture_parts(const PictureSize& size, const PixelWindow& window,
                                       std::uint64_t pixel_bytes, int margin);

}  // namespace slim
