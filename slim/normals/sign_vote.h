#pragma once

#include "slim/base/vec.h"

namespace slim {

/// What one point of a pair says of the other's sign, -1 to 1: positive if their unit normals m and
/// n agree. It is the product of what these are across the line d from one point to the other, and
/// so the mean of the product of the normals (Hoppe et al. 1992) and of that with one of them
/// mirrored at the plane between the points (Xie et al. 2003), which is right on every circle but
/// takes noise of a plane for its two sides (notes/0002).
/// square  of the length of d, not 0
template <class T>
T sign_vote(const Vec3<T>& m, const Vec3<T>& n, const Vec3<T>& d, T square) {
    return dot(m, n) - dot(m, d) * dot(n, d) / square;
}

}  // namespace slim
