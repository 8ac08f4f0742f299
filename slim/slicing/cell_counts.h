#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// One cell of a grid that holds points: [at w, (at + 1) w) along each axis.
struct Cell {
    std::array<std::int64_t, 3> at;
    std::uint64_t n_points;
};

/// Counts of points in the occupied cells of a grid, at most kMostCells of them, over a range that
/// need not be known beforehand: when they become too many, eight merge in one. Cells are as wide
/// as a power of two and begin at multiples of it, so merging and cutting are exact, and the counts
/// do not depend on the order of the points. 4 MiB, whatever the cloud.
class CellCounts {
public:
    static constexpr std::size_t kMostCells = std::size_t{1} << 17;

    /// Chooses the first width for about this box of finite points; it can only grow from here.
    explicit CellCounts(const Bbox& about);

    /// p must be finite. Cost: a look into a hash table.
    void add(const Vec3d& p);
    double width() const { return width_; }
    /// The occupied cells, by place.
    std::vector<Cell> cells() const;

private:
    struct Slot {
        std::uint64_t key = 0;  // place from base_, 21 bits an axis
        std::uint64_t n_points = 0;
    };
    std::int64_t bin_of(double x) const;
    bool key_of(const Vec3d& p, std::uint64_t& key) const;
    Slot& slot_of(std::uint64_t key);
    template <class Done>
    void coarsen_until(Done&& is_done);

    double width_, per_width_;          // powers of two: products are as exact as quotients
    std::array<std::int64_t, 3> base_;  // of the cell whose key is 0, 0, 0 beside the offset
    std::vector<Slot> slots_;
    std::size_t n_used_ = 0;
};

/// The same cells, twice as wide; by place.
std::vector<Cell> merged(const std::vector<Cell>& cells);

/// Square root of the area that a point has, on a surface: from cells that hold many points. 0
/// without points. A plane meets 1.5 cells for each w^2 of it, on average over its slopes.
double surface_spacing(std::vector<Cell> cells, double width);

}  // namespace slim
