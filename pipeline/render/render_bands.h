#pragma once

#include "pipeline/render/render_view.h"
#include "raytrace/picture.h"
#include "raytrace/shade.h"

#include <functional>

namespace slim {

/// Paints rows [begin, end) of a frame: a picture as wide as the frame, with that many rows.
using RowPainter = std::function<Picture(const RowRange& rows)>;

/// A picture of `size` from a frame of a whole multiple of it, painted band by band and averaged:
/// only one band is held at the frame's own size. Each pixel is as if painted and averaged at once.
Picture paint_in_bands(const PictureSize& frame, const PictureSize& size, const RowPainter& paint);

}  // namespace slim
