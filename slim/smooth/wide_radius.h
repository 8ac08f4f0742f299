#pragma once

#include "slim/neighbors/point_pyramid.h"
#include "slim/tree/ball_index.h"

#include <functional>
#include <span>
#include <vector>

namespace slim {

/// What a model knows of a leaf beside its surfel.
struct LeafNoise {
    double fit_error = 0;  ///< RMS residual of its fit
    double n_points = 0;   ///< in its ball at the fit
};

/// Told between batches of leaves how many are done, from one thread; may throw to stop.
using EachBatch = std::function<void(std::size_t done, std::size_t total)>;

/// parallel_blocks() in batches; the result of a body that keeps its own by index does not depend on them.
void parallel_batches(std::size_t n, std::size_t grain, const EachBatch& each_batch,
                      const std::function<void(std::size_t begin, std::size_t end)>& body);

/// For each leaf of the index the radius of the wide fits that leave the least error in the surface about it, by
/// their variance and their bias, the latter a mean over the leaves around (notes/0003). Zero: the leaf itself
/// is better, sharp, ends at a rim, or has too few points about it. In parallel, the same for any thread count.
/// noise     of each leaf, in the index's order
/// diagonal  of the model
/// cost      1.8 kB a leaf while it runs; about 12 discs of up to 16,000 points a leaf where noise is strong, 3 where it is weak
std::vector<double> wide_radii(const BallIndex& model, std::span<const LeafNoise> noise,
                               const PointPyramid& points, double diagonal, const EachBatch& each_batch = {});

}  // namespace slim
