#pragma once

#include "raytrace/frame.h"
#include "raytrace/renderer.h"
#include "slim/model/surfel_tree.h"

namespace slim {

/// Draws a model by forward projection in two stages (Ohtake 2005, sec. 3): the first hit per pixel
/// on surfels trimmed to kHitTrim of their radius, then the blend of all surfels around it. Single
/// precision relative to each surfel, SIMD over pixels, tiles over threads; the same bytes for any
/// number of threads. `out` is reset to the request's window and channels;
/// what is not wanted is not computed.
///
/// Departs from the paper: surfels that oppose the first hit's gradient are not blended
/// (NUMERICS 4.4); a pixel left without weight keeps its first hit.
/// throws  ConfigError for the camera, the size or the window; FormatError for a tree with cycles
/// cost    O(nodes above the cut + cut + covered pixels x overlap)
RenderStats render_forward(const SurfelTree& tree, const RenderRequest& request, GBuffer& out);

}  // namespace slim
