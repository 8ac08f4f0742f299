#include "slim/cover/point_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr std::size_t kMostCells = 64;

std::uint64_t row_of(std::size_t n) {
    return n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
}

/// Combines `size` copies of a mask that are shifted by 0, 1, .. cells, by doubling: along x if
/// `shift` moves bits, along y if it moves rows.
template <class Shifted, class Combine>
void combine_shifted(CellMask& m, std::size_t size, const Shifted& shifted,
                     const Combine& combine) {
    for (std::size_t have = 1; have < size;) {
        const std::size_t by = std::min(have, size - have);
        const CellMask moved = shifted(m, by);
        for (std::size_t y = 0; y < m.n; ++y) m.rows[y] = combine(m.rows[y], moved.rows[y]);
        have += by;
    }
}

/// Moved towards lesser x or y (`back`) or greater ones; what comes in is empty.
CellMask moved_x(const CellMask& m, std::size_t by, bool back) {
    CellMask out = m;
    for (std::size_t y = 0; y < m.n; ++y)
        out.rows[y] = by >= 64 ? 0 : back ? m.rows[y] >> by : (m.rows[y] << by) & row_of(m.n);
    return out;
}

CellMask moved_y(const CellMask& m, std::size_t by, bool back) {
    CellMask out;
    out.n = m.n;
    for (std::size_t y = 0; y < m.n; ++y)
        if (back ? y + by < m.n : y >= by) out.rows[y] = m.rows[back ? y + by : y - by];
    return out;
}

CellMask swept(CellMask m, std::size_t size, bool back) {
    const auto either = [&](std::uint64_t a, std::uint64_t b) { return back ? a & b : a | b; };
    combine_shifted(
        m, size, [&](const CellMask& a, std::size_t by) { return moved_x(a, by, back); }, either);
    combine_shifted(
        m, size, [&](const CellMask& a, std::size_t by) { return moved_y(a, by, back); }, either);
    return m;
}

}  // namespace

bool CellMask::any() const {
    std::uint64_t all = 0;
    for (std::size_t y = 0; y < n; ++y) all |= rows[y];
    return all != 0;
}

std::size_t CellMask::count() const {
    int sum = 0;
    for (std::size_t y = 0; y < n; ++y) sum += std::popcount(rows[y]);
    return static_cast<std::size_t>(sum);
}

CellMask CellMask::without(const CellMask& other) const {
    CellMask out = *this;
    for (std::size_t y = 0; y < n; ++y) out.rows[y] &= ~other.rows[y];
    return out;
}

CellMask CellMask::operator&(const CellMask& other) const {
    CellMask out = *this;
    for (std::size_t y = 0; y < n; ++y) out.rows[y] &= other.rows[y];
    return out;
}

CellMask CellMask::corners_of_squares(std::size_t size) const { return swept(*this, size, true); }

CellMask CellMask::squares_at_corners(std::size_t size) const { return swept(*this, size, false); }

CellMask CellMask::grown(std::size_t cells) const {
    const CellMask right = swept(*this, cells + 1, false);
    CellMask out = right;
    // the other two sides: the same, turned by half
    const auto either = [](std::uint64_t a, std::uint64_t b) { return a | b; };
    combine_shifted(
        out, cells + 1, [](const CellMask& a, std::size_t by) { return moved_x(a, by, true); },
        either);
    combine_shifted(
        out, cells + 1, [](const CellMask& a, std::size_t by) { return moved_y(a, by, true); },
        either);
    return out;
}

PointRaster::PointRaster(std::size_t n) {
    const double wanted = 2 * std::sqrt(static_cast<double>(n) / std::numbers::pi);
    filled.n = std::clamp<std::size_t>(static_cast<std::size_t>(wanted), 1, kMostCells);
    cell = 2.0 / static_cast<double>(filled.n);
    // a coordinate of 1 would be in the next cell
    per_length_ = 0.499999f * static_cast<float>(filled.n);
}

CellMask disc_of_cells(std::size_t n, double radius) {
    CellMask out;
    out.n = n;
    const double cell = 2.0 / static_cast<double>(n);
    const auto farthest = [&](std::size_t i) {
        const double lo = static_cast<double>(i) * cell - 1;
        return std::max(std::abs(lo), std::abs(lo + cell));
    };
    for (std::size_t y = 0; y < n; ++y)
        for (std::size_t x = 0; x < n; ++x)
            if (std::hypot(farthest(x), farthest(y)) <= radius) out.set(x, y);
    return out;
}

}  // namespace slim
