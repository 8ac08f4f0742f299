#pragma once

#include "slim/base/vec.h"
#include "slim/model/surfel.h"
#include "slim/tree/ball_index.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// A place where three faces meet, of all leaves that show it.
struct Corner {
    Vec3d point;
    double radius;
};

/// The corners of sharp leaves: of leaves in their order, the first one's stands for those of later
/// ones within a share of their radius. Read by any number of threads.
class Corners {
public:
    explicit Corners(const BallIndex& leaves);

    /// The number of a leaf's corner; kNoCorner without one in its ball.
    std::uint32_t of_leaf(std::size_t leaf) const { return of_leaf_[leaf]; }
    const Corner& operator[](std::uint32_t number) const { return found_[number]; }

private:
    std::uint32_t find_or_add(const BallIndex& leaves, const Surfel& s, const Vec3d& x);

    std::vector<const Surfel*> near_;
    std::vector<Corner> found_;
    std::vector<std::uint32_t> of_leaf_;
};

}  // namespace slim
