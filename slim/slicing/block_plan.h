#pragma once

#include "slim/base/bbox.h"
#include "slim/slicing/cell_counts.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// What the program takes whatever the cloud: code, libraries, buffers, threads.
inline constexpr std::uint64_t kProgramBytes = std::uint64_t{16} << 20;
/// What a stage needs at most for one point that it holds: the fit 190 bytes (measured), estimated
/// normals 165, 200 of happy_stand_raw and 210 in noise of 1 % (within the tenth that --memory may
/// be passed by).
inline constexpr std::uint64_t kBytesPerPoint = 192;
/// A block keeps a file open while points are dealt out.
inline constexpr std::uint64_t kMostBlocks = 500;

/// How many points a stage may hold at a time.
std::uint64_t points_in_memory(std::uint64_t memory_bytes);

/// A point of [lo, hi): every point is in one region of a plan.
bool is_in(const Bbox& region, const Vec3d& p);
/// A point of the region, its faces included, or not farther than a distance from it along any
/// axis.
bool is_near(const Bbox& region, const Vec3d& p, double distance);
/// Whether a box that is not empty has places that are near in that sense; whether all of it is.
bool comes_near(const Bbox& region, const Bbox& box, double distance);
bool is_near(const Bbox& region, const Bbox& box, double distance);

/// Space cut into blocks of nearly equal numbers of points, each across the longest side of what it
/// holds: blocks are as thick as they can be, also where a cloud is flat, so that a halo around one
/// costs the fewest points.
struct BlockPlan {
    /// A plane; children >= 0 are further splits, block b is -1 - b.
    struct Split {
        std::size_t axis;
        double cut;  ///< below: x < cut
        std::int32_t below, above;
    };
    std::vector<Split> splits;            ///< the first is the root; none: one block
    std::vector<std::uint64_t> n_points;  ///< of each block, exact; every block has some
    std::vector<Bbox> regions;            ///< half open, infinite outwards

    std::size_t n_blocks() const { return n_points.size(); }
    /// Cost: log2(blocks) comparisons.
    std::size_t block_of(const Vec3d& p) const;
};

/// About `wanted` blocks, cut between cells; fewer where cells are, as an empty block is never
/// made. wanted >= 1, cells not empty
BlockPlan plan_blocks(std::vector<Cell> cells, double width, std::uint64_t wanted);

/// Points in blocks with a halo around each, one value a halo.
struct HaloCounts {
    std::vector<std::uint64_t> most;  ///< of the fullest block
    std::vector<std::uint64_t> all;   ///< of all blocks, added up
};

/// halos: falling. Or a few more points, as whole cells count. Cost: cells times blocks, 5 ns.
HaloCounts count_within(const BlockPlan& plan, std::span<const Cell> cells, double width,
                        std::span<const double> halos);

}  // namespace slim
