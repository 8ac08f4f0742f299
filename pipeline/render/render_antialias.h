#pragma once

#include "pipeline/render/render_job.h"

#include <cstdint>

namespace slim {

/// Paints the pictures of frames.plain that may be averaged and draws their pixels at edges
/// (edge_pixels of each picture, so that none depends on what else is asked for) again with 2 x 2
/// samples, those of a picture of twice the size. They go into frames.smoothed, `shaded` into the
/// plain frame's.
/// cost  what the windows about edges cost at twice the size
void smooth_edges(const RenderJob& job, const PicturePart& part, Frames& frames);

/// Bytes that it takes for a pixel of the picture besides the plain frame's planes.
std::uint64_t smoothing_bytes(const RenderJob& job);

/// An AOV of a part as it is painted, before any background: smoothed, if it is.
Picture painted_aov(const RenderJob& job, const std::string& aov, const AovLook& look,
                    const Frames& frames);

}  // namespace slim
