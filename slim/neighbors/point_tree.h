#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/box_tree.h"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace slim {

/// Points in Morton order as flat arrays under a tree of boxes: answers ball queries by ranges of
/// the arrays. Built once, read by any number of threads.
class PointTree {
public:
    static constexpr std::size_t kBucket = BoxTree::kBucket;

    /// Takes the chosen points of a block, which must be in Morton order already (morton_order
    /// below).
    PointTree(const PointBlock& block, std::span<const std::uint32_t> chosen);

    std::size_t size() const { return source_.size(); }
    Vec3d position(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
    Vec3f normal(std::size_t i) const { return {nx_[i], ny_[i], nz_[i]}; }
    /// Index in the block of the tree's i-th point.
    std::uint32_t source(std::size_t i) const { return source_[i]; }

    /// Calls body(begin, end) for every bucket whose box meets the ball; a superset of the ball's
    /// points.
    template <class Body>
    void for_buckets_in_ball(const Vec3d& center, double radius, Body&& body) const {
        boxes_.for_buckets_in_ball(center, radius, std::forward<Body>(body));
    }

    const double* x() const { return x_.data(); }
    const double* y() const { return y_.data(); }
    const double* z() const { return z_.data(); }
    const float* nx() const { return nx_.data(); }
    const float* ny() const { return ny_.data(); }
    const float* nz() const { return nz_.data(); }

    /// Edge length that 16 neighbours of point i share, a first guess of the density there.
    double bucket_diagonal(std::size_t i) const { return boxes_.bucket(i / kBucket).diagonal(); }

private:
    std::vector<double> x_, y_, z_;
    std::vector<float> nx_, ny_, nz_;
    std::vector<std::uint32_t> source_;
    BoxTree boxes_;
};

/// Indices of a block's points along the Morton curve of `box`; equal places of the curve in index
/// order. Points in that order already (as those of oriented slices are) cost one look.
std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box);

/// Puts a block's points in the order of the Morton curve of `box`; equal places of the curve by
/// coordinates, then by id: duplicates lie side by side, whatever order they came in.
/// Memory: 36 bytes a point meanwhile.
void sort_along_curve(PointBlock& block, const Bbox& box);

}  // namespace slim
