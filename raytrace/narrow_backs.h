#pragma once

#include "raytrace/shade.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Where a surface is seen from behind through something narrow: through a crack between leaves,
/// or past the ragged rim of a scan. 1 at hits that face away where up to a sixth of the disc of
/// shade_reach about them does, 0 from two fifths on (an edge of what is wide has a half) and at
/// all others.
///
/// normals, hit  as of shade; planes that reach shade_reach beyond what is wanted make parts agree
/// returns       a plane of their size
/// cost          O(pixels), 32 looks about each hit that faces away; parallel over rows
std::vector<float> narrow_backs(int width, int height, const ShadeView& view,
                                const NormalPlanes& normals, std::span<const std::uint8_t> hit);

}  // namespace slim
