#pragma once

#include "slim/base/vec.h"
#include "slim/normals/covariance.h"

#include <cmath>

// Neighbourhoods that say little of the surface: those on a line of a scan whose next ones are far
// (notes/0005). Normals and the noise take more neighbours there.

namespace slim {

/// Whether points lie on such a line: of scans spaced alike one neighbourhood in a thousand does.
inline bool is_on_line(const Spread& s) { return !(s.middle > 1.0 / 8 * s.largest); }

/// Whether points are flat. A noisy scan line is, too, in the plane of its noise: a strip.
inline bool is_flat(const Spread& s) { return s.smallest < 1.0 / 16 * s.middle; }

/// Whether the plane of points is another one, by more than 45 degrees, than that of a unit normal.
inline bool is_other_plane(const Spread& s, const Vec3d& normal) {
    return std::abs(dot(s.normal, normal)) < 0.7071;
}

}  // namespace slim
