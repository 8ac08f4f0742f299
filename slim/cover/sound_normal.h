#pragma once

#include "slim/cover/cover_rules.h"
#include "slim/fit/sharp_search.h"
#include "slim/neighbors/point_tree.h"

#include <cstdint>

namespace slim {

/// The normal of a point: its own, unit, or that of the others in its bucket where these agree and
/// its own is across theirs (cosine between kOtherSideCos and kLeastCos), as single ones of grazing
/// rays are. Along such a normal a point on a plain surface lies anywhere off it, and seen along it
/// half of the surface faces away (notes/0020). Zero for a point without one.
Vec3d sound_normal(const PointTree& points, std::uint32_t place);

/// Whether single normals of a cloud are turned by chance: elsewhere one across its neighbours' may
/// be a crease's.
inline bool has_stray_normals(const CoverRules& rules) {
    return rules.ladder.contrary_share >= kCleanNormals;
}

}  // namespace slim
