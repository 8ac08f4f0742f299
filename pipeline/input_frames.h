#pragma once

#include "slim/base/bbox.h"

#include <span>
#include <string>

namespace slim {

/// What to warn of where two clouds of a job lie so far apart that they cannot be of one frame, as where only one is
/// georeferenced: the two that are farthest apart for their size, with their boxes. Empty where all may be of one
/// frame: no gap between two boxes is wider than ten diagonals of the larger.
/// paths, boxes  of each cloud; world frame; an empty box counts for nothing
/// cost          a few flops a pair of clouds
std::string other_frame_text(std::span<const std::string> paths, std::span<const Bbox> boxes);

}  // namespace slim
