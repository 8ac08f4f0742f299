#pragma once

#include "slim/model/point_block.h"

#include <vector>

namespace slim::test {

/// Share of normals on the true ones' side.
inline double share_agreeing(const PointBlock& block, const std::vector<Vec3f>& truth) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < block.size(); ++i) n += dot(block.normal[i], truth[i]) > 0;
    return static_cast<double>(n) / static_cast<double>(block.size());
}

}  // namespace slim::test
