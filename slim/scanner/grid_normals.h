#pragma once

#include "slim/scanner/range_grid.h"

namespace slim {

/// Distance in cells between the neighbours that span a normal: 1, or as many as it takes to span
/// three standard deviations of the noise, at most 8 (a scanner's software smooths likewise).
std::uint64_t normal_stride(double sigma, double spacing);

/// A scanner's own idea of the normal at a return: sum of the cross products of neighbours `stride`
/// cells away in the four quadrants (so weighted by area), towards the scanner. Neighbours beyond a
/// jump of the range (six spacings and six sigma) are left out; without any quadrant the view
/// direction stands in. Needs `stride` rows of halo where the scan has them.
Vec3d grid_normal(const RangeGrid& grid, const Station& station, std::uint64_t row,
                  std::uint64_t col, std::uint64_t stride, double sigma);

}  // namespace slim
