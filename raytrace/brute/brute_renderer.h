#pragma once

#include "raytrace/frame.h"
#include "raytrace/renderer.h"
#include "slim/model/surfel_tree.h"

namespace slim {

/// The reference picture: same request, same result within rounding as render_forward at lod 0, by
/// plain loops in doubles through slim/blend. No tiles, no hierarchy, no lanes; lod_px is not used
/// (leaves only, by definition). Each row of pixels considers the leaves whose ball meets the plane
/// of its rays.
/// cost  O(rows x leaves + pixels x leaves on a row); for tests and `--mode brute`
RenderStats render_brute(const SurfelTree& tree, const RenderRequest& request, GBuffer& out);

}  // namespace slim
