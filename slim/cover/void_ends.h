#pragma once

#include "slim/cover/covering_surfel.h"
#include "slim/cover/leaf_voids.h"
#include "slim/cover/point_raster.h"
#include "slim/model/rim.h"

#include <cstdint>

namespace slim {

/// Cells whose middles lie within a straight end.
CellMask within(const PointRaster& raster, const CellMask& cells, const Rim& rim);

/// One end before all voids of the drawn disc, or two that leave out all of them together; filled:
/// the rest of the disc, of which they leave out as little as they can.
void find_ends(const CellMask& voids, const CellMask& filled, LeafVoids& out);

/// Ends a leaf there: its rims, and what it covers within them, where data go on beyond no nearer
/// to them than a spacing. False, and nothing is done, if the steps of rims do not allow it, or its
/// own point (in the block) would not be covered any more; `share` is then the share of its radius
/// with which the first would stand right, 1 if none is known.
bool end_at_voids(const LeafVoids& voids, std::uint32_t point, CoveringSurfel& leaf, double& share);

}  // namespace slim
