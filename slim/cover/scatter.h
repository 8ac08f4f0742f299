#pragma once

#include "slim/cover/surfel_fit.h"

#include <cstdint>

namespace slim {

inline constexpr double kSparse = 4;  ///< over the usual radius: a region so thin is a surface or strays
inline constexpr std::uint32_t kFewest = 3;  ///< points that any leaf may have

/// Whether a leaf's points are no surface of its size: a pole, a twig, the crown of a tree. A disc among them
/// would stand in the air.
/// sparse: the finest ball with enough points is far larger than the cloud's usual one.
bool is_scatter(const CoveringSurfel& leaf, bool forced, bool sparse);

}  // namespace slim
