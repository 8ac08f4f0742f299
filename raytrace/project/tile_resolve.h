#pragma once

#include "raytrace/frame.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <span>

namespace slim {

/// Divides a tile's sums, turns them into the wanted channels and writes them to the G-buffer, whose
/// pixel (0, 0) is the window's. Counts covered pixels and those that keep q^ for want of weight.
void resolve_tile(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                  const DrawList& list, std::span<const std::uint32_t> entries, TileBuffers& t,
                  GBuffer& out);

}  // namespace slim
