#pragma once

#include "slim/model/surfel_tree.h"
#include "slim/tree/ball_index.h"

#include <cstddef>
#include <vector>

namespace slim {

/// A point of a model's surface.
struct SurfaceSample {
    Vec3d point;      ///< frame of the job
    Vec3d normal;     ///< unit, outwards
    double area = 0;  ///< that it stands for: all add up to about the surface's
};

/// Points on the surface that pictures show, always the same ones of a model.
///
/// Every leaf that is drawn (loose ones are not) is sampled in its core, the ball of radius alpha
/// rho about its centre (alpha = 2/3: what covers), at the seeds of a sunflower over the core's
/// disc: equal areas, no random number. A seed is moved along the leaf's normal onto the leaf,
/// within its core and its rims, and from there onto the blended surface (eq. (6)). Cores overlap:
/// a sample stands for its share of the core's area over the number of cores that hold it.
///
/// n_wanted  about as many are made, in proportion to the cores' areas, at least four a leaf; the
///           surface of a leaf that nothing is left of yields none
/// cost      about 3 us a sample and core
std::vector<SurfaceSample> sample_surface(const SurfelTree& tree, const BallIndex& index,
                                          std::size_t n_wanted);

}  // namespace slim
