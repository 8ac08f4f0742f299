#pragma once

#include "slim/base/bbox.h"

#include <span>
#include <string>

namespace slim {

/// What to warn of where the clouds of a job fall into groups so far apart that they cannot be of
/// one frame, as where only one is georeferenced: one cloud of the first's group and one of
/// another, with their boxes. Empty where all may be of one frame: each is reached from the first
/// by steps between boxes no wider than ten diagonals of the larger, as tiles in a row are.
/// paths, boxes  of each cloud; world frame; an empty box counts for nothing
/// cost          a few flops a pair of clouds that are near along one axis: of 20,000 tiles in a
///               square 0.3 s, in a row 0.004 s; where there is something to warn of, of the
///               first's group and all others
std::string other_frame_text(std::span<const std::string> paths, std::span<const Bbox> boxes);

}  // namespace slim
