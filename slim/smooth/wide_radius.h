#pragma once

#include "slim/base/parallel_batches.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/tree/ball_index.h"

#include <span>
#include <vector>

namespace slim {

/// What a model knows of a leaf beside its surfel.
struct LeafNoise {
    double fit_error = 0;  ///< RMS residual of its fit
    double n_points = 0;   ///< in its ball at the fit
};

/// What is known of a leaf once wide fits were tried about it.
struct WideRadius {
    double radius = 0;    ///< of the fits that leave the least error; zero: the leaf is kept
    double sq_noise = 0;  ///< of a point about the fit of that radius; zero where the leaf is kept
    bool in_cloud = false;  ///< the cloud holds the leaf's points, or as many
};

/// For each leaf of the index the radius of the wide fits that leave the least error in the surface
/// about it, by their variance and their bias, the latter a mean over the leaves around
/// (notes/0003, 0004). The leaf itself is better if it is sharp, ends at a rim, or has too few
/// points about it. In parallel, the same for any thread count.
/// noise     of each leaf, in the index's order
/// diagonal  of the model
/// cost      0.9 kB a leaf while it runs; about 12 discs of up to 8,000 points a leaf where noise
///           is strong, 3 where it is weak
std::vector<WideRadius> wide_radii(const BallIndex& model, std::span<const LeafNoise> noise,
                                   const PointPyramid& points, double diagonal,
                                   const EachBatch& each_batch = {});

/// The same without looking for any: all leaves are kept, where memory is short. Cost:
/// 24 bytes a leaf.
std::vector<WideRadius> kept_radii(const BallIndex& model, std::span<const LeafNoise> noise,
                                   const PointPyramid& points);

}  // namespace slim
