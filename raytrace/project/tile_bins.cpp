#include "raytrace/project/tile_bins.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace slim {
namespace {

/// Parts of the order, each with counts of its own: no more than a few, whatever the model.
constexpr std::size_t kLeastPart = 2048, kMostParts = 16;

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
    const std::size_t n_tiles = bins.n_tiles();
    const std::size_t grain = std::max(kLeastPart, (order.size() + kMostParts - 1) / kMostParts);
    const std::size_t n_parts = (order.size() + grain - 1) / grain;
    // visit(part and tile, entry), parts in parallel, each in its order.
    const auto for_parts = [&](const auto& visit) {
        parallel_blocks(order.size(), grain, [&](std::size_t begin, std::size_t end) {
            for (const std::uint32_t i : order.subspan(begin, end - begin))
                for_each_tile(window, bins.columns, rects[i],
                              [&](std::size_t t) { visit(begin / grain * n_tiles + t, i); });
        });
    };
    std::vector<std::uint32_t> next(n_parts * n_tiles, 0);  // of a part in a tile: first how many, then where
    for_parts([&](std::size_t at, std::uint32_t) { ++next[at]; });
    bins.start.assign(n_tiles + 1, 0);
    for (std::size_t t = 0; t < n_tiles; ++t) {
        std::size_t start = bins.start[t];
        for (std::size_t part = 0; part < n_parts; ++part)
            start += std::exchange(next[part * n_tiles + t], static_cast<std::uint32_t>(start));
        bins.start[t + 1] = start;
    }
    SLIM_CHECK(bins.start.back(), <=, std::numeric_limits<std::uint32_t>::max());  // places of `next`
    bins.entries.resize(bins.start.back());
    for_parts([&](std::size_t at, std::uint32_t i) { bins.entries[next[at]++] = i; });
    return bins;
}

}  // namespace slim
