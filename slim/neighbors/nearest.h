#pragma once

#include "slim/base/vec.h"
#include "slim/neighbors/box_tree.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace slim {

/// Exact k nearest neighbours at distinct places of points in Morton order (sort_along_curve): of
/// points that coincide only the first is anybody's neighbour. The points of one bucket share the
/// walk down the tree of boxes; distances are doubles, scanned by lanes (notes/0001).
class NearestSearch {
public:
    /// Keeps the view and builds the boxes over it; 4 bytes a point.
    explicit NearestSearch(std::span<const Vec3d> positions);

    std::size_t size() const { return positions_.size(); }
    std::span<const Vec3d> positions() const { return positions_; }
    const BoxTree& boxes() const { return boxes_; }
    /// Whether point i lies where the one before it lies.
    bool is_repeat(std::size_t i) const { return i > 0 && positions_[i] == positions_[i - 1]; }
    /// Whether a bucket holds a repeat.
    bool has_repeats(std::size_t bucket) const { return has_repeats_[bucket] != 0; }

    /// Calls visit(w, neighbours) once for each wanted[w], by several threads at once. The
    /// neighbours are the point itself (or the first of its repeats) and the nearest others, k in
    /// all, or as many as there are; in no order, but in the same one always. Of two as far the one
    /// of lower index is taken.
    /// wanted: rising indices; repeats are better left out: each costs a scan of all of its kind.
    /// Cost: 0.5 us a point and core at k = 16 where all points are wanted, 1 us where few are.
    using Visit = std::function<void(std::size_t w, std::span<const std::uint32_t> neighbors)>;
    void for_each(std::span<const std::uint32_t> wanted, std::size_t k, const Visit& visit) const;

private:
    std::span<const Vec3d> positions_;
    BoxTree boxes_;
    std::vector<std::uint8_t> has_repeats_;  // a byte a bucket: threads write side by side
};

}  // namespace slim
