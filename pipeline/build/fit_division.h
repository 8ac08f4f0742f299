#pragma once

#include "pipeline/build/plan_file.h"

#include <cstdint>
#include <vector>

namespace slim {

/// How the fit of a job in slices is divided (slim/cover/notes/0006).
struct FitDivision {
    /// levels before it are fitted once for all slices; 1: the job has one slice
    int first_fine = 1;
    /// level that this one fit ends at: first_fine, for gaps that wait, or one that the sample no
    /// longer resolves
    int last_coarse = 1;
    double halo = 0;      ///< a slice sees the points of others so near to its region, model units
    double share = 1;     ///< of all points that the coarse levels are fitted to
};

/// Rungs of the ladder from the first fine level's radius to the halo's: a leaf of a fine level may
/// be so much larger than it (2.6 times), and what is decided at the rim of the halo has died away
/// at the region.
inline constexpr int kHaloRungs = 2;

/// The halo of a job of diagonal L whose first fine level is 1, 2, ...: falling.
std::vector<double> possible_halos(double diagonal);

/// The halo is as wide as the largest leaf that the sample does not resolve, so that every leaf is
/// somebody's. Of the samples that fit into memory_bytes, as the fullest slice and its halo must,
/// the one for which the fewest points are read in all: a small one makes wide halos. Where none
/// leaves room for its halo, the largest sample with the widest halo there is room for, but no less
/// than a fit can do with; where the number of slices was given, its halo whatever it takes.
FitDivision divide_fit(const SlicePlan& plan, std::uint64_t memory_bytes);

/// Points of the fullest slice and its halo.
std::uint64_t points_held(const SlicePlan& plan, const FitDivision& division);

/// Whether the halo is as wide as it should be.
bool halo_suffices(const SlicePlan& plan, const FitDivision& division);

/// Points that the fits of all slices and of the coarse levels hold, added up.
std::uint64_t points_read(const SlicePlan& plan, const FitDivision& division);

}  // namespace slim
