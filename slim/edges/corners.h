#pragma once

#include "slim/base/vec.h"
#include "slim/edges/edge_leaf.h"
#include "slim/model/surfel.h"
#include "slim/tree/ball_index.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// A place where three faces or more meet, of all leaves that show it.
struct Corner {
    Vec3d point;
    double radius;
};

/// The corners of sharp leaves: of leaves in their order, the first one's stands for those of later
/// ones within a share of their radius. Read by any number of threads.
class Corners {
public:
    explicit Corners(const BallIndex& leaves);

    /// The number of the corner in a leaf's ball, of those at an edge of it, that is nearest to p;
    /// kNoCorner without one.
    std::uint32_t nearest(std::size_t leaf, std::size_t pair, const Vec3d& p) const;
    const Corner& operator[](std::uint32_t number) const { return found_[number]; }

private:
    /// A leaf's corner: its number among all.
    struct OfLeaf {
        std::uint32_t number;
        LeafCorner own;
    };
    std::span<const OfLeaf> of_leaf(std::size_t leaf) const {
        return std::span(of_leaves_).subspan(begin_[leaf], begin_[leaf + 1] - begin_[leaf]);
    }
    std::uint32_t find_or_add(const BallIndex& leaves, const Surfel& s, const Vec3d& x);

    std::vector<const Surfel*> near_;
    std::vector<Corner> found_;
    std::vector<OfLeaf> of_leaves_;        ///< leaf by leaf
    std::vector<std::size_t> begin_ = {0}; ///< of a leaf's in of_leaves_; one more than leaves
};

}  // namespace slim
