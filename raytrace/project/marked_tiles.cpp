#include "raytrace/project/marked_tiles.h"

#include "raytrace/project/tile_bins.h"

namespace slim {

MarkedTiles::MarkedTiles(const SampleMask& mask, const PixelWindow& grid)
    : x_(grid.x),
      y_(grid.y),
      columns_(static_cast<std::size_t>(grid.width / kTileSize)),
      rows_(static_cast<std::size_t>(grid.height / kTileSize)),
      sums_((columns_ + 1) * (rows_ + 1)) {
    for (std::size_t row = 0; row < rows_; ++row)
        for (std::size_t column = 0; column < columns_; ++column) {
            const PixelWindow tile{x_ + static_cast<int>(column) * kTileSize,
                                   y_ + static_cast<int>(row) * kTileSize, kTileSize, kTileSize};
            sums_[at(column + 1, row + 1)] = sums_[at(column, row + 1)] +
                                             sums_[at(column + 1, row)] - sums_[at(column, row)] +
                                             (mask.any_sample(tile) ? 1u : 0u);
        }
}

bool MarkedTiles::any(const ScreenRect& r) const {
    const auto tile = [](int n) { return static_cast<std::size_t>(n / kTileSize); };
    const std::size_t left = tile(r.x0 - x_), right = tile(r.x1 - 1 - x_) + 1;
    const std::size_t top = tile(r.y0 - y_), bottom = tile(r.y1 - 1 - y_) + 1;
    return sums_[at(right, bottom)] + sums_[at(left, top)] !=
           sums_[at(right, top)] + sums_[at(left, bottom)];
}

}  // namespace slim
