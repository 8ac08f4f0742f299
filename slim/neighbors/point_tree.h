#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"
#include "slim/model/point_block.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Points in Morton order as flat arrays under an implicit tree of boxes (16 points a bucket, 4 boxes a
/// node): answers ball queries by ranges of the arrays. Built once, read by any number of threads.
class PointTree {
public:
    static constexpr std::size_t kBucket = 16;
    static constexpr std::size_t kFanout = 4;

    /// Takes the chosen points of a block, which must be in Morton order already (morton_order below).
    PointTree(const PointBlock& block, std::span<const std::uint32_t> chosen);

    std::size_t size() const { return source_.size(); }
    Vec3d position(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
    Vec3f normal(std::size_t i) const { return {nx_[i], ny_[i], nz_[i]}; }
    /// Index in the block of the tree's i-th point.
    std::uint32_t source(std::size_t i) const { return source_[i]; }

    /// Calls body(begin, end) for every bucket whose box meets the ball; a superset of the ball's points.
    template <class Body>
    void for_buckets_in_ball(const Vec3d& center, double radius, Body&& body) const {
        struct Entry {
            std::uint32_t level, index;
        };
        Entry stack[128];
        std::size_t depth = 0;
        if (levels_.empty()) return;
        const auto top = static_cast<std::uint32_t>(levels_.size() - 1);
        for (std::uint32_t i = 0; i < levels_[top].size(); ++i) stack[depth++] = {top, i};
        const double sq_radius = radius * radius;
        while (depth > 0) {
            const Entry e = stack[--depth];
            if (sq_distance(levels_[e.level][e.index], center) >= sq_radius) continue;
            if (e.level == 0) {
                const std::size_t begin = e.index * kBucket;
                body(begin, begin + kBucket < size() ? begin + kBucket : size());
                continue;
            }
            const std::size_t first = e.index * kFanout;
            const std::size_t count = levels_[e.level - 1].size();
            const std::size_t last = first + kFanout < count ? first + kFanout : count;
            for (std::size_t c = last; c-- > first;)
                stack[depth++] = {e.level - 1, static_cast<std::uint32_t>(c)};
        }
    }

    const double* x() const { return x_.data(); }
    const double* y() const { return y_.data(); }
    const double* z() const { return z_.data(); }
    const float* nx() const { return nx_.data(); }
    const float* ny() const { return ny_.data(); }
    const float* nz() const { return nz_.data(); }

    /// Edge length that 16 neighbours of point i share, a first guess of the density there.
    double bucket_diagonal(std::size_t i) const { return levels_[0][i / kBucket].diagonal(); }

private:
    static double sq_distance(const Bbox& b, const Vec3d& p) {
        const double dx = std::max({b.lo.x - p.x, p.x - b.hi.x, 0.0});
        const double dy = std::max({b.lo.y - p.y, p.y - b.hi.y, 0.0});
        const double dz = std::max({b.lo.z - p.z, p.z - b.hi.z, 0.0});
        return dx * dx + dy * dy + dz * dz;
    }
    void build_boxes();

    std::vector<double> x_, y_, z_;
    std::vector<float> nx_, ny_, nz_;
    std::vector<std::uint32_t> source_;
    std::vector<std::vector<Bbox>> levels_;  // 0: buckets; the last has at most kFanout boxes
};

/// Indices of a block's points along the Morton curve of `box`; equal places in index order.
std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box);

}  // namespace slim
