#include "raytrace/project/tile_bins.h"

namespace slim {
namespace {

template <class Visit>
void for_each_tile(const PixelWindow& window, int columns, const ScreenRect& r, Visit&& visit) {
    const int column_0 = (r.x0 - window.x) / kTileSize, column_1 = (r.x1 - 1 - window.x) / kTileSize;
    const int row_0 = (r.y0 - window.y) / kTileSize, row_1 = (r.y1 - 1 - window.y) / kTileSize;
    for (int row = row_0; row <= row_1; ++row)
        for (int column = column_0; column <= column_1; ++column)
            visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(column));
}

}  // namespace

PixelWindow whole_tiles(const PixelWindow& w) {
    const int x = w.x / kTileSize * kTileSize, y = w.y / kTileSize * kTileSize;
    const auto rounded = [](int n) { return (n + kTileSize - 1) / kTileSize * kTileSize; };
    return {x, y, rounded(w.x + w.width - x), rounded(w.y + w.height - y)};
}

TileBins tile_bins(const PixelWindow& window, std::span<const ScreenRect> rects,
                   std::span<const std::uint32_t> order) {
    TileBins bins;
    bins.columns = (window.width + kTileSize - 1) / kTileSize;
    bins.rows = (window.height + kTileSize - 1) / kTileSize;
    bins.start.assign(bins.n_tiles() + 1, 0);
    for (const std::uint32_t i : order)
        for_each_tile(window, bins.columns, rects[i], [&](std::size_t t) { ++bins.start[t + 1]; });
    for (std::size_t t = 0; t < bins.n_tiles(); ++t) bins.start[t + 1] += bins.start[t];
    bins.entries.resize(bins.start.back());
    std::vector<std::size_t> next(bins.start.begin(), bins.start.end() - 1);
    for (const std::uint32_t i : order)
        for_each_tile(window, bins.columns, rects[i],
                      [&](std::size_t t) { bins.entries[next[t]++] = i; });
    return bins;
}

}  // namespace slim
