#pragma once

#include "slim/base/bbox.h"
#include "slim/base/reporter.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <string>

namespace slim {

/// A file and the box of its points, world frame.
struct PlacedFile {
    std::string path;
    Bbox box;
};

/// Whether the boxes have a point in common.
bool meet(const Bbox& a, const Bbox& b);

/// The model's input points.
PlacedFile placed(const std::string& path, const ModelHeader& header);

/// Throws NumericalError: the model has no surface in reach of any of the cloud's `n_points` finite
/// points. Names both files and their boxes, and what makes them lie so: units if their sizes
/// differ by a factor of 8 or more, a frame where their boxes do not meet, else a turn.
[[noreturn]] void refuse_apart(const PlacedFile& cloud, const PlacedFile& model,
                               std::uint64_t n_points);

/// Warns if most of the cloud's n points lie in no surfel's support; returns whether they do.
bool warn_of_lost(const std::string& cloud, const std::string& model, std::uint64_t lost,
                  std::uint64_t n, Reporter& reporter);

}  // namespace slim
