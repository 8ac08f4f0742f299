#pragma once

#include "slim/model/point_block.h"
#include "slim/neighbors/nearest.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Which scans (by number) of a registered cloud have their normals turned round against those of
/// the scans that they overlap: of two sides the one that faces away from its sensors, where these
/// say anything, else the one with fewer points. Neighbours of different scans vote as in
/// notes/0002; a scan of the other side of a thin sheet, which lies behind, is none. All false,
/// mostly; empty for a cloud of one scan.
/// samples: points that ask their 16 neighbours, without repeats
/// facing: of each scan, points whose normals face its sensor less the others; may be shorter
/// Cost: 2 us a sample. Deterministic.
std::vector<bool> contrary_scans(const PointBlock& points, const NearestSearch& search,
                                 std::span<const std::uint32_t> samples,
                                 std::span<const std::int64_t> facing = {});

}  // namespace slim
