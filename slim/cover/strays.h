#pragma once

#include "slim/base/vec.h"
#include "slim/fit/ball_points.h"
#include "slim/neighbors/point_tree.h"

namespace slim {

/// How the points of a ball lie about its centre.
struct BallShape {
    double growth = 0;  ///< points over those within half of the radius: 4 on a surface, 8 where
                        ///< they fill space
    double thick = 0;   ///< share of their variance that is across their plane: 0 of a surface, a
                        ///< third where they fill space
    double off = 0;     ///< distance of the centre from their plane, over the radius
};

/// ball: at least one point. Cost: a few passes over the points.
BallShape shape_of(const BallPoints<double>& ball);

/// Whether a point whose smallest ball with enough points has that radius stands where only strays
/// are (notes/0019): about it points are hardly denser than those, and in the ball of twice the
/// radius they fill space, or are a surface that the centre lies off. To be asked where points are
/// sparse only: noise thicker than their spacing looks like that.
/// stray_density: strays to the volume; ball: workspace.
/// Cost: a ball of four times the points on a surface.
bool stands_among_strays(const PointTree& points, const Vec3d& center, double radius,
                         double stray_density, BallPoints<double>& ball);

}  // namespace slim
