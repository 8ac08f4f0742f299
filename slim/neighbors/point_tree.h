#pragma once

#include "slim/base/bbox.h"
#include "slim/base/unfilled_vector.h"
#include "slim/base/vec.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/box_tree.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace slim {

/// The points of one bucket side by side: a ball query reads them in one stretch of memory, by
/// lanes. Five lines of the caches, as it is what a query waits for: positions are off by 3e-8 of
/// the bucket's width at most, normals by 1e-3 degrees (notes/0003).
struct alignas(64) PointBucket {
    static constexpr std::size_t kSize = BoxTree::kBucket;
    static constexpr float kUnit = 32767;          ///< length of a normal
    float x[kSize], y[kSize], z[kSize];            ///< from `origin`; infinite beyond the last
                                                   ///< point: in no ball
    std::int16_t nx[kSize], ny[kSize], nz[kSize];  ///< normals times kUnit; zero: none
    Vec3d origin;                                  ///< middle of the bucket's box, world frame
    bool is_exact;  ///< `origin` and the floats give the positions to
                    ///< the last bit, as in most clouds of floats
};
static_assert(sizeof(PointBucket) == 320);

/// Points in Morton order in buckets under a tree of boxes: answers ball queries by buckets.
/// Built once, read by any number of threads. 28 bytes a point, 24 if it is the
/// whole block in its order; refers to the block, which must outlive it.
class PointTree {
public:
    static constexpr std::size_t kBucket = PointBucket::kSize;

    /// Takes the chosen points of a block, which must be in Morton order already (morton_order
    /// below).
    PointTree(const PointBlock& block, std::span<const std::uint32_t> chosen);

    std::size_t size() const { return size_; }
    Vec3d position(std::size_t i) const { return block_->position[source(i)]; }
    /// Zero if the block has none.
    Vec3f normal(std::size_t i) const {
        return block_->has_normals() ? block_->normal[source(i)] : Vec3f{};
    }
    /// Index in the block of the tree's i-th point.
    std::uint32_t source(std::size_t i) const {
        return source_.empty() ? static_cast<std::uint32_t>(i) : source_[i];
    }

    /// Calls body(first, bucket) for every bucket whose box meets the ball, `first` being the index
    /// of its first point; a superset of the ball's points.
    template <class Body>
    void for_buckets_in_ball(const Vec3d& center, double radius, Body&& body) const {
        // Memory is what a ball waits for: its buckets are fetched while the walk goes on.
        constexpr std::size_t kAhead = 24;
        std::size_t waiting[kAhead];
        std::size_t n = 0;
        const auto serve = [&] {
            for (std::size_t k = 0; k < n; ++k) body(waiting[k] * kBucket, buckets_[waiting[k]]);
            n = 0;
        };
        boxes_.for_buckets_in_ball(center, radius, [&](std::size_t begin, std::size_t) {
            const std::size_t b = begin / kBucket;
            for (std::size_t line = 0; line < sizeof(PointBucket); line += 64)
                __builtin_prefetch(reinterpret_cast<const char*>(&buckets_[b]) + line);
            waiting[n++] = b;
            if (n == kAhead) serve();
        });
        serve();
    }

    /// Edge length that 16 neighbours of point i share, a first guess of the density there.
    double bucket_diagonal(std::size_t i) const { return bucket_box(i).diagonal(); }
    /// The box of the bucket that holds point i.
    Bbox bucket_box(std::size_t i) const { return boxes_.bucket(i / kBucket); }

private:
    void fill_bucket(std::size_t bucket);

    const PointBlock* block_;
    std::size_t size_;
    UnfilledVector<PointBucket> buckets_;
    std::vector<std::uint32_t> source_;  // empty if it is the block, point by point
    BoxTree boxes_;
};

/// Indices of a block's points along the Morton curve of `box`; equal places of the curve in index
/// order. Points in that order already (as those of oriented slices are) cost one look.
std::vector<std::uint32_t> morton_order(const PointBlock& block, const Bbox& box);

/// Puts a block's points in the order of the Morton curve of `box`; equal places of the curve by
/// coordinates, then by id: duplicates lie side by side, whatever order they came in.
/// Memory: 40 bytes a point meanwhile.
void sort_along_curve(PointBlock& block, const Bbox& box);

}  // namespace slim
