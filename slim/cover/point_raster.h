#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace slim {

/// A square of up to 64 x 64 cells as bits: row y holds cell (x, y) as bit x. Cells beyond n are 0.
struct CellMask {
    std::size_t n = 0;
    std::array<std::uint64_t, 64> rows{};

    bool at(std::size_t x, std::size_t y) const {
        return x < n && y < n && (rows[y] >> x & 1) != 0;
    }
    void set(std::size_t x, std::size_t y) { rows[y] |= std::uint64_t{1} << x; }
    bool any() const;
    std::size_t count() const;
    CellMask without(const CellMask& other) const;
    CellMask operator&(const CellMask& other) const;

    /// Cells that are the first (least x and y) of a full square of size x size cells.
    CellMask corners_of_squares(std::size_t size) const;
    /// The cells of the squares that have these as their first ones.
    CellMask squares_at_corners(std::size_t size) const;
    /// What full squares of size x size cells fill of it.
    CellMask opened(std::size_t size) const {
        return corners_of_squares(size).squares_at_corners(size);
    }
    /// Grown by so many cells on each side; the whole square bounds it.
    CellMask grown(std::size_t cells) const;
};

/// The places of a leaf's points in its tangent plane as cells of the square [-1, 1]^2, over rho,
/// on average one point a cell of the unit disc, or more where 64 cells do not suffice.
struct PointRaster {
    CellMask filled;
    double cell = 0;  ///< side, over rho

    /// For n points.
    explicit PointRaster(std::size_t n);
    std::size_t cells() const { return filled.n; }
    /// The cell of a coordinate in [-1, 1].
    std::size_t cell_of(float x) const {
        return static_cast<std::size_t>((x + 1.0f) * per_length_);
    }
    double middle_of(std::size_t i) const { return (static_cast<double>(i) + 0.5) * cell - 1; }
    void add(float u, float v) { filled.set(cell_of(u), cell_of(v)); }

private:
    float per_length_;
};

/// The cells that lie wholly in the disc of that radius about the middle of [-1, 1]^2.
CellMask disc_of_cells(std::size_t n, double radius);

/// Calls visit(x, y) for each cell of a set.
template <class Visit>
void for_cells(const CellMask& cells, const Visit& visit) {
    for (std::size_t y = 0; y < cells.n; ++y)
        for (std::uint64_t bits = cells.rows[y]; bits != 0; bits &= bits - 1)
            visit(static_cast<std::size_t>(std::countr_zero(bits)), y);
}

}  // namespace slim
