#include "slim/scanner/grid_normals.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slim {
namespace {

/// The cell at an offset if it continues the surface at `here`, else nullptr.
const Return* neighbor(const RangeGrid& grid, const Return& here, std::uint64_t row,
                       std::uint64_t col, std::int64_t d_row, std::int64_t d_col, double jump) {
    const std::int64_t r = static_cast<std::int64_t>(row - grid.first_row) + d_row;
    const std::int64_t c = static_cast<std::int64_t>(col) + d_col;
    if (r < 0 || c < 0 || r >= static_cast<std::int64_t>(grid.rows) ||
        c >= static_cast<std::int64_t>(grid.cols))
        return nullptr;
    const Return& cell =
        grid.cells[static_cast<std::size_t>(r) * grid.cols + static_cast<std::size_t>(c)];
    return cell.valid && std::abs(cell.range - here.range) < jump ? &cell : nullptr;
}

}  // namespace

std::uint64_t normal_stride(double sigma, double spacing) {
    return static_cast<std::uint64_t>(std::clamp(std::ceil(3 * sigma / spacing), 1.0, 8.0));
}

Vec3d grid_normal(const RangeGrid& grid, const Station& station, std::uint64_t row,
                  std::uint64_t col, std::uint64_t stride, double sigma) {
    const Return& here = grid.at(row, col);
    const auto s = static_cast<std::int64_t>(stride);
    const double jump =
        6 * (station.pitch * static_cast<double>(stride) * here.range + sigma);
    // Right, up, left, down: successive pairs turn counter-clockwise as the scanner sees them.
    const std::array<const Return*, 4> around{neighbor(grid, here, row, col, 0, s, jump),
                                              neighbor(grid, here, row, col, -s, 0, jump),
                                              neighbor(grid, here, row, col, 0, -s, jump),
                                              neighbor(grid, here, row, col, s, 0, jump)};
    Vec3d sum;
    for (std::size_t i = 0; i < 4; ++i) {
        const Return* a = around[i];
        const Return* b = around[(i + 1) % 4];
        if (a && b) sum += cross(a->position - here.position, b->position - here.position);
    }
    const Vec3d back = normalized(station.position - here.position), n = normalized(sum);
    if (sq_length(n) == 0) return back;
    return dot(n, back) < 0 ? -n : n;
}

}  // namespace slim
