#pragma once

#include "raytrace/frame.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <span>

namespace slim {

/// Divides a tile's sums, turns them into the wanted channels and writes all its pixels to the
/// G-buffer, whose pixel (0, 0) is the window's. Counts covered pixels and those that keep q^ for
/// want of weight.
void resolve_tile(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                  std::span<const DrawItem> items, std::span<const std::uint32_t> entries,
                  const TileSums& sums, TileBuffers& t, GBuffer& out);

/// Asks for the memory that resolve_tile will write, well before: rows of a tile lie on different
/// pages, and no prefetcher of the machine sees them coming.
void fetch_tile(const PixelWindow& window, int first_x, int first_y, GBuffer& out);

/// Pixels without a hit, in all channels, where some tiles side by side that begin at (first_x,
/// first_y) of the picture meet the window.
void clear_tiles(const PixelWindow& window, int first_x, int first_y, int n_tiles, GBuffer& out);

}  // namespace slim
