#pragma once

#include "raytrace/frame.h"
#include "raytrace/renderer.h"
#include "raytrace/sample_mask.h"
#include "slim/model/surfel_tree.h"

namespace slim {

/// Draws a model by forward projection in two stages (Ohtake 2005, sec. 3): the first hit per pixel
/// on surfels trimmed to kHitTrim of their radius, then the blend of all surfels around it. Single
/// precision relative to each surfel, SIMD over pixels, tiles over threads; the same bytes for any
/// number of threads. `out` is reset to the request's window and channels;
/// what is not wanted is not computed. `only`, if given: the request is of a picture of twice the
/// size, of which these samples are drawn, each as in a picture that has them all; elsewhere there
/// is no hit.
///
/// Departs from the paper: surfels that oppose the first hit's gradient are not blended
/// (NUMERICS 4.4); a pixel left without weight keeps its first hit.
/// throws  ConfigError for the camera, the size or the window; FormatError for a tree with cycles
/// cost    O(nodes above the cut + cut + covered pixels x overlap)
RenderStats render_forward(const SurfelTree& tree, const RenderRequest& request, GBuffer& out,
                           const SampleMask* only = nullptr);

}  // namespace slim
