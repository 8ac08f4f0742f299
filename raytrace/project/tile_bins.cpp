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

/// The tiles of a rectangle: rows + 1 by columns + 1 from the first on.
struct TileRect {
    std::size_t first, columns, rows;

    TileRect(const PixelWindow& window, std::size_t row_length, const ScreenRect& r) {
        const auto tile = [](int pixel) { return static_cast<std::size_t>(pixel) / kTileSize; };
        const std::size_t column = tile(r.x0 - window.x), row = tile(r.y0 - window.y);
        first = row * row_length + column;
        columns = tile(r.x1 - 1 - window.x) - column, rows = tile(r.y1 - 1 - window.y) - row;
    }
    /// visit(tile, whether it is in) for the tiles. Of up to two by two all four are visited, in or
    /// not: most are such, and there is no telling which.
    template <class Visit>
    [[gnu::always_inline]] void for_each(std::size_t row_length, Visit&& visit) const {
        if (columns <= 1 && rows <= 1) {
            visit(first, true);
            visit(first + 1, columns != 0);
            visit(first + row_length, rows != 0);
            visit(first + row_length + 1, (columns & rows) != 0);
            return;
        }
        for (std::size_t row = 0; row <= rows; ++row)
            for (std::size_t column = 0; column <= columns; ++column)
                visit(first + row * row_length + column, true);
    }
};

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
    const auto row_length = static_cast<std::size_t>(bins.columns);
    const std::size_t part_length = n_tiles + row_length + 1;  // with what is visited and never in
    // visit(part and tile, whether it is in, entry), parts in parallel, each in its order.
    const auto for_parts = [&](const auto& visit) {
        parallel_blocks(order.size(), grain, [&](std::size_t begin, std::size_t end) {
            const std::size_t part = begin / grain * part_length;
            for (const std::uint32_t i : order.subspan(begin, end - begin))
                TileRect(window, row_length, rects[i])
                    .for_each(
                        row_length, [&](std::size_t t, bool in)
                                        __attribute__((always_inline)) { visit(part + t, in, i); });
        });
    };
    // of a part in a tile: first how many, then where
    std::vector<std::uint32_t> next(n_parts * part_length, 0);
    for_parts([&](std::size_t at, bool in, std::uint32_t)
                  __attribute__((always_inline)) { next[at] += in; });
    bins.start.assign(n_tiles + 1, 0);
    for (std::size_t t = 0; t < n_tiles; ++t) {
        std::size_t start = bins.start[t];
        for (std::size_t part = 0; part < n_parts; ++part)
            start += std::exchange(next[part * part_length + t], static_cast<std::uint32_t>(start));
        bins.start[t + 1] = start;
    }
    // places of `next`
    SLIM_CHECK(bins.start.back(), <=, std::numeric_limits<std::uint32_t>::max());
    bins.entries.resize(bins.start.back());
    for_parts([&](std::size_t at, bool in, std::uint32_t i) __attribute__((always_inline)) {
        std::uint32_t nowhere;
        std::uint32_t* const to = in ? &bins.entries[next[at]] : &nowhere;
        *to = i, next[at] += in;
    });
    return bins;
}

}  // namespace slim
