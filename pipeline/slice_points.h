#pragma once

#include "pipeline/plan_file.h"
#include "slim/model/point_block.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace slim {

/// How the fit of a job in slices is divided (slim/cover/notes/0005).
struct FitDivision {
    int first_fine = 1;  ///< levels before it are fitted once for all slices; 1: the job has one slice
    double halo = 0;     ///< a slice sees the points of others so near to its slab, model units
    double share = 1;    ///< of all points that the coarse levels are fitted to
};

/// Rungs of the ladder from the first fine level's radius to the halo's: a leaf of a fine level may be so
/// much larger than it (2.6 times), and what is decided at the rim of the halo has died away at the slab.
inline constexpr int kHaloRungs = 2;

/// The halo is at most half of the thinnest slab, so that a slice and its halo fit into memory_bytes; the
/// sample of the coarse levels takes as much.
FitDivision divide_fit(const SlicePlan& plan, std::uint64_t memory_bytes);

/// The oriented points of a slice and those of its neighbours within the halo, in the slices' order.
/// Only what is wanted of the neighbours is held.
PointBlock read_with_halo(const std::string& work, const SlicePlan& plan, std::size_t slice,
                          double halo);

/// The points in_share() of all slices.
PointBlock read_coarse_sample(const std::string& work, const SlicePlan& plan, double share,
                              std::uint64_t seed);

}  // namespace slim
