#pragma once

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/base/vec.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim {

/// An implicit tree of boxes over points in Morton order: 16 points a bucket, 8 boxes a node. It
/// keeps the boxes alone (4 bytes a point), not the points. Built once, read by any number of
/// threads.
class BoxTree {
public:
    static constexpr std::size_t kBucket = 16;
    static constexpr std::size_t kFanout = 8;

    BoxTree() = default;
    /// position(i) for i in [0, n), in Morton order. Parallel.
    template <class Position>
    BoxTree(std::size_t n, Position&& position) : size_(n) {
        if (n == 0) return;
        n_buckets_ = (n + kBucket - 1) / kBucket;
        std::vector<Boxes> lowest((n_buckets_ + kFanout - 1) / kFanout);
        parallel_blocks(n_buckets_, 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                Bbox box;
                for (std::size_t i = b * kBucket; i < std::min(n, (b + 1) * kBucket); ++i)
                    box.extend(position(i));
                lowest[b / kFanout].set(b % kFanout, box);
            }
        });
        add_levels(std::move(lowest));
    }

    std::size_t size() const { return size_; }
    std::size_t n_buckets() const { return n_buckets_; }
    Bbox bucket(std::size_t i) const { return levels_[0][i / kFanout].get(i % kFanout); }

    /// Calls body(begin, end) for every bucket whose box meets the ball; a superset of the ball's
    /// points.
    template <class Body>
    void for_buckets_in_ball(const Vec3d& center, double radius, Body&& body) const {
        for_buckets_near({center, center}, radius, body);
    }

    /// The same for every bucket whose box is nearer to a box than the radius.
    template <class Body>
    void for_buckets_near(const Bbox& box, double radius, Body&& body) const {
        if (levels_.empty()) return;
        const double sq_radius = radius * radius;
        // The lowest nodes are too many for the caches: they are fetched while the walk goes on.
        constexpr std::size_t kAhead = 16;
        std::uint32_t waiting[kAhead];
        std::size_t n = 0;
        const auto serve = [&] {
            for (std::size_t k = 0; k < n; ++k) {
                const std::uint64_t near = levels_[0][waiting[k]].nearer_than(sq_radius, box);
                for (std::uint64_t bits = near; bits != 0; bits &= bits - 1) {
                    const auto c = static_cast<std::size_t>(std::countr_zero(bits));
                    const std::size_t begin = (waiting[k] * kFanout + c) * kBucket;
                    body(begin, std::min(begin + kBucket, size_));
                }
            }
            n = 0;
        };
        for_lowest_nodes_near(box, sq_radius, [&](std::uint32_t node) {
            for (std::size_t line = 0; line < sizeof(Boxes); line += 64)
                __builtin_prefetch(reinterpret_cast<const char*>(&levels_[0][node]) + line);
            waiting[n++] = node;
            if (n == kAhead) serve();
        });
        serve();
    }

private:
    /// Calls body(node) for the nodes of level 0 whose box is near, in order.
    template <class Body>
    void for_lowest_nodes_near(const Bbox& box, double sq_radius, Body&& body) const {
        struct Entry {
            std::uint32_t level, index;
        };
        Entry stack[128];
        std::size_t depth = 1;
        stack[0] = {static_cast<std::uint32_t>(levels_.size() - 1), 0};
        while (depth > 0) {
            const Entry e = stack[--depth];
            if (e.level == 0) {
                body(e.index);
                continue;
            }
            // Which of the boxes are near is anybody's guess: no branch depends on it.
            const std::uint64_t near = levels_[e.level][e.index].nearer_than(sq_radius, box);
            for (std::uint32_t c = kFanout; c-- > 0;) {
                stack[depth] = {e.level - 1, e.index * std::uint32_t{kFanout} + c};
                depth += near >> c & 1;
            }
        }
    }

    /// The boxes of one node, side by side: one comparison each serves them all.
    struct alignas(64) Boxes {
        using Lanes = stdx::simd<double, stdx::simd_abi::deduce_t<double, kFanout>>;
        double lo[3][kFanout], hi[3][kFanout];

        Boxes() {
            for (std::size_t c = 0; c < kFanout; ++c) set(c, Bbox{});
        }
        void set(std::size_t c, const Bbox& b) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                lo[axis][c] = b.lo[axis], hi[axis][c] = b.hi[axis];
        }
        Bbox get(std::size_t c) const {
            return {{lo[0][c], lo[1][c], lo[2][c]}, {hi[0][c], hi[1][c], hi[2][c]}};
        }
        /// Bit c: the squared distance of box c to b is less than that. Never of an empty box.
        std::uint64_t nearer_than(double sq_radius, const Bbox& b) const {
            Lanes sq = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const Lanes below = Lanes(lo[axis], stdx::element_aligned) - b.hi[axis];
                const Lanes above = b.lo[axis] - Lanes(hi[axis], stdx::element_aligned);
                const Lanes gap = stdx::max(stdx::max(below, above), Lanes(0));
                sq += gap * gap;
            }
            return lane_bits(sq < sq_radius);
        }
    };

    void add_levels(std::vector<Boxes> lowest) {
        levels_.push_back(std::move(lowest));
        while (levels_.back().size() > 1) {
            const std::vector<Boxes>& below = levels_.back();
            std::vector<Boxes> above((below.size() + kFanout - 1) / kFanout);
            for (std::size_t i = 0; i < below.size(); ++i) {
                Bbox all;
                for (std::size_t c = 0; c < kFanout; ++c) all.extend(below[i].get(c));
                above[i / kFanout].set(i % kFanout, all);
            }
            levels_.push_back(std::move(above));
        }
    }

    std::size_t size_ = 0, n_buckets_ = 0;
    std::vector<std::vector<Boxes>> levels_;  // 0: of buckets; the last is one node
};

}  // namespace slim
