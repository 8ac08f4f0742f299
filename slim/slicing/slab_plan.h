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

/// What the program takes whatever the cloud: code, libraries, buffers, threads.
inline constexpr std::uint64_t kProgramBytes = std::uint64_t{16} << 20;
/// What a stage needs at most for one point that it holds: the fit 190 bytes (measured), estimated normals 136.
inline constexpr std::uint64_t kBytesPerPoint = 192;
/// A slice takes the points of others within half of the thinnest slab on either side.
inline constexpr double kHaloShare = 0.5;
/// A slab keeps a file open while points are dealt out.
inline constexpr std::uint64_t kMostSlabs = 500;

/// How many points a stage may hold at a time.
std::uint64_t points_in_memory(std::uint64_t memory_bytes);

/// How many slabs keep the points of one and its halo within the memory; 1 where all points are.
std::uint64_t slabs_for_memory(std::uint64_t n_points, std::uint64_t memory_bytes);

/// Cuts an axis into about `wanted` slabs of nearly equal counts, at edges of bins; fewer where
/// points crowd into single bins, as an empty slab is never made. counts: all points along that
/// axis; wanted >= 1
SlabPlan plan_slabs(const AxisHistogram& counts, std::uint64_t wanted);

/// Thickness of the thinnest slab of a cloud that reaches from lo to hi.
double thinnest_slab(const std::vector<double>& cuts, double lo, double hi);

/// Number of the slab that x belongs to.
std::size_t slab_of(double x, const std::vector<double>& cuts);

}  // namespace slim
