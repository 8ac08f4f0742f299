#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Points as flat arrays, local frame: world = origin + position (the one origin of a whole job, in
/// doubles). Either all points have a normal or `normal` is empty; the same for `scan`.
/// A zero normal means "none measured".
struct PointBlock {
    Vec3d origin;
    std::vector<Vec3d> position;
    std::vector<Vec3f> normal;
    /// number of the point in the whole input, keys its randomness
    std::vector<std::uint64_t> id;
    std::vector<std::uint16_t> scan; ///< which scan of a registered cloud it came from

    std::size_t size() const { return position.size(); }
    bool empty() const { return position.empty(); }
    bool has_normals() const { return !normal.empty(); }
    bool has_scans() const { return !scan.empty(); }
};

}  // namespace slim
