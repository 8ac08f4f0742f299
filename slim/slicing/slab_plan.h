#pragma once

#include "slim/slicing/axis_histogram.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Slab i holds the points with cuts[i-1] <= x < cuts[i] (open at both ends of the row).
struct SlabPlan {
    std::vector<double> cuts;            ///< increasing, one fewer than slabs
    std::vector<std::uint64_t> n_points; ///< of each slab, exact; every slab has some

    std::size_t n_slabs() const { return n_points.size(); }
};

/// What a stage needs for one point of a slab. Measured beyond 14 MiB of the program itself:
/// normals that are given 81 bytes, estimated 136; the fit 160, its halo and the coarse surfels
/// besides.
inline constexpr std::uint64_t kBytesPerSlabPoint = 256;
/// A slab keeps a file open while points are dealt out.
inline constexpr std::uint64_t kMostSlabs = 500;

/// How many slabs keep the points of one within the memory.
std::uint64_t slabs_for_memory(std::uint64_t n_points, std::uint64_t memory_bytes);

/// Cuts an axis into about `wanted` slabs of nearly equal counts, at edges of bins; fewer where
/// points crowd into single bins, as an empty slab is never made. counts: all points along that
/// axis; wanted >= 1
SlabPlan plan_slabs(const AxisHistogram& counts, std::uint64_t wanted);

/// Number of the slab that x belongs to.
std::size_t slab_of(double x, const std::vector<double>& cuts);

}  // namespace slim
