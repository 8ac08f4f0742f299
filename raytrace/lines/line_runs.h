#pragma once

#include "raytrace/lines/feature_line.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Points [begin, end) of a line.
struct Run {
    std::size_t begin, end;
};

/// In the picture, pixels.
float length_of(const std::vector<LinePoint>& points, const Run& run);

/// Runs of points that are all marked or all not, in their order.
std::vector<Run> runs_of(const std::vector<std::uint8_t>& marked);

/// A loop is opened where a run of marked points begins, so that no run is cut in two at its seam.
void open_at_mark(FeatureLine& line, std::vector<std::uint8_t>& marked);

/// What is left of a line without the runs that are marked;
/// each rest takes `overlap` points of what it leaves.
void add_unmarked(FeatureLine line, const std::vector<std::uint8_t>& marked, std::size_t overlap,
                  std::vector<FeatureLine>& out);

}  // namespace slim
