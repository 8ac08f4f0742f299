#pragma once

#include "raytrace/project/screen_rect.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

inline constexpr int kTileSize = 32;

/// Which entries of a draw list touch which 32x32 tile of the window, in its order.
struct TileBins {
    int columns = 0, rows = 0;
    std::vector<std::size_t> start;      ///< n_tiles + 1 offsets into `entries`
    std::vector<std::uint32_t> entries;  ///< of the draw list

    std::size_t n_tiles() const {
        return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    }
    std::span<const std::uint32_t> of(std::size_t tile) const {
        return std::span(entries).subspan(start[tile], start[tile + 1] - start[tile]);
    }
};

/// The window grown to whole tiles of the picture's grid, so that a tile and the surfels in it are
/// the same for any window: a window's pixels then have the bytes of the whole picture's.
PixelWindow whole_tiles(const PixelWindow& window);

/// `order` names the rectangles to sort in, none of them empty.
TileBins tile_bins(const PixelWindow& window, std::span<const ScreenRect> rects,
                   std::span<const std::uint32_t> order);

}  // namespace slim
