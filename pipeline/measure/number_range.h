#pragma once

#include "slim/base/bbox.h"

#include <cstdint>
#include <string>
#include <utility>

namespace slim {

/// Throws DataError where sums of squared distances between `n` points of two files leave the range
/// of numbers: the box of both, world frame, overflows, or has an extent whose square vanishes.
void require_squares(const std::pair<std::string, std::string>& files, const Bbox& box,
                     std::uint64_t n);

}  // namespace slim
