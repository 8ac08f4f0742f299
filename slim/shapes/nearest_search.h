#pragma once

#include "slim/shapes/shape.h"

#include <optional>

namespace slim {

struct SearchedPoint {
    Vec3d point;  ///< on the surface
    bool stationary =
        false;  ///< the line to x is perpendicular to the surface there; else it lies on a crease
};

/// The nearest point of a closed shape to any finite x: the box is halved again and again, cells
/// nearest to x first; the Lipschitz constant tells which hold no surface, and cells of 1/64 of the
/// diagonal start Newton's method.
///
/// start  a point that may be near, counts if it is on the surface
///
/// Exact (about 1e-12) where the foot is stationary, unless two minima lie within one cell of 1/256
/// of the diagonal. On a crease too far by less than 1e-3 of the diagonal for certain (by the cells
/// that are left); measured: below 1e-5. Beyond 1e6 diagonals as from there along the same line,
/// which changes the distance by less than rounding.
///
/// returns  nothing if no point is known that well after 16,384 cells
/// cost     one value of f a cell: some hundreds from outside, thousands from the middle of the
/// shape and to a crease
std::optional<SearchedPoint> search_nearest(const Shape& shape, const Vec3d& x,
                                            const Vec3d* start = nullptr);

}  // namespace slim
