#pragma once

#include "slim/cover/covering_surfel.h"
#include "slim/cover/point_raster.h"
#include "slim/fit/ball_points.h"
#include "slim/model/rim.h"

#include <cstddef>
#include <cstdint>

namespace slim {

/// A straight end of a leaf: direction of a rim, and how far it reaches there, over rho.
struct VoidEnd {
    int direction = 0;
    double reach = 1;
};

/// What a leaf would bridge, and the straight ends that leave it out (notes/0024).
struct LeafVoids {
    bool any = false;       ///< of its drawn part
    std::size_t n_ends = 0; ///< that leave all of it out; 0: no two do
    VoidEnd ends[2];
    double spacing = 0;     ///< of the points where there are some, over rho
    CellMask voids;         ///< places without points, for sure
    PointRaster raster{1};
};

/// Whether the drawn disc of a leaf holds a square of five by five spacings without a point, by
/// what it covers alone: of few leaves, whose ball is worth a closer look. Cost: a few operations a
/// point, and some hundred a row of at most 64 cells.
bool may_bridge(const CoveringSurfel& leaf);

/// The voids of a leaf: places where, beside so many points, the lack of points is no chance. None
/// where scan lines, sparse outskirts or a change of density explain it. ball: all points of the
/// leaf's ball that do not face away. rims: those that it would have without. Cost: a pass
/// over the ball, then some operations for each cell and direction of a rim.
LeafVoids voids_of(const CoveringSurfel& leaf, const BallPoints<double>& ball, PackedRims rims);

}  // namespace slim
