#pragma once

#include "slim/model/surfel.h"

#include <cstdint>
#include <functional>
#include <span>

namespace slim {

/// A surfel as the fit leaves it, with what the tree and the pictures want to know of the fit.
struct FittedSurfel {
    Surfel surfel;
    double fit_error = 0;        ///< eps, RMS residual, model units
    std::uint32_t n_points = 0;  ///< points in the ball at the fit
    std::uint8_t level = 1;      ///< level that accepted it, 1 is the coarsest
    std::uint8_t flags = 0;      ///< NodeFlags of surfel_tree.h; an internal surfel has no kLeaf
    std::uint64_t point_id = 0;  ///< the input point that is its centre
};

/// Hands surfels to its argument one by one, so that they need not all be in memory: the same ones
/// in the same order whenever it is called.
using SurfelVisit = std::function<void(const FittedSurfel&)>;
using SurfelSource = std::function<void(const SurfelVisit&)>;

/// Those of an array that outlives the source.
inline SurfelSource source_of(std::span<const FittedSurfel> surfels) {
    return [surfels](const SurfelVisit& visit) {
        for (const FittedSurfel& s : surfels) visit(s);
    };
}

}  // namespace slim
