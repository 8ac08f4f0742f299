#pragma once

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/base/vec.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim {

/// An implicit tree of boxes over points in Morton order: 16 points a bucket, 4 boxes a node. It keeps
/// the boxes alone (4 bytes a point), not the points. Built once, read by any number of threads.
class BoxTree {
public:
    static constexpr std::size_t kBucket = 16;
    static constexpr std::size_t kFanout = 4;

    BoxTree() = default;
    /// position(i) for i in [0, n), in Morton order. Parallel.
    template <class Position>
    BoxTree(std::size_t n, Position&& position) : size_(n) {
        if (n == 0) return;
        std::vector<Bbox> buckets((n + kBucket - 1) / kBucket);
        parallel_blocks(buckets.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b)
                for (std::size_t i = b * kBucket; i < std::min(n, (b + 1) * kBucket); ++i)
                    buckets[b].extend(position(i));
        });
        add_levels(std::move(buckets));
    }

    std::size_t size() const { return size_; }
    std::size_t n_buckets() const { return levels_.empty() ? 0 : levels_[0].size(); }
    const Bbox& bucket(std::size_t i) const { return levels_[0][i]; }

    /// Calls body(begin, end) for every bucket whose box meets the ball; a superset of the ball's points.
    template <class Body>
    void for_buckets_in_ball(const Vec3d& center, double radius, Body&& body) const {
        for_buckets_near({center, center}, radius, body);
    }

    /// The same for every bucket whose box is nearer to a box than the radius.
    template <class Body>
    void for_buckets_near(const Bbox& box, double radius, Body&& body) const {
        struct Entry {
            std::uint32_t level, index;
        };
        Entry stack[128];
        std::size_t depth = 0;
        if (levels_.empty()) return;
        const double sq_radius = radius * radius;
        // Which of the boxes are near is anybody's guess: no branch depends on it.
        const auto push_near = [&](std::uint32_t level, std::size_t first, std::size_t last) {
            const std::vector<Bbox>& boxes = levels_[level];
            for (std::size_t c = last; c-- > first;) {
                stack[depth] = {level, static_cast<std::uint32_t>(c)};
                depth += sq_distance(boxes[c], box) < sq_radius ? 1 : 0;
            }
        };
        push_near(static_cast<std::uint32_t>(levels_.size() - 1), 0, levels_.back().size());
        while (depth > 0) {
            const Entry e = stack[--depth];
            if (e.level == 0) {
                const std::size_t begin = e.index * kBucket;
                body(begin, std::min(begin + kBucket, size_));
                continue;
            }
            const std::size_t first = e.index * kFanout;
            push_near(e.level - 1, first, std::min(first + kFanout, levels_[e.level - 1].size()));
        }
    }

private:
    static double sq_distance(const Bbox& a, const Bbox& b) {
        const auto gap = [](double a_lo, double a_hi, double b_lo, double b_hi) {
            return std::max(std::max(a_lo - b_hi, b_lo - a_hi), 0.0);
        };
        const double dx = gap(a.lo.x, a.hi.x, b.lo.x, b.hi.x);
        const double dy = gap(a.lo.y, a.hi.y, b.lo.y, b.hi.y);
        const double dz = gap(a.lo.z, a.hi.z, b.lo.z, b.hi.z);
        return dx * dx + dy * dy + dz * dz;
    }
    void add_levels(std::vector<Bbox> buckets) {
        levels_.push_back(std::move(buckets));
        while (levels_.back().size() > kFanout) {
            const std::vector<Bbox>& below = levels_.back();
            std::vector<Bbox> above((below.size() + kFanout - 1) / kFanout);
            for (std::size_t i = 0; i < below.size(); ++i) above[i / kFanout].extend(below[i]);
            levels_.push_back(std::move(above));
        }
    }

    std::size_t size_ = 0;
    std::vector<std::vector<Bbox>> levels_;  // 0: buckets; the last has at most kFanout boxes
};

}  // namespace slim
