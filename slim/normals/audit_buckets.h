#pragma once

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/base/unfilled_vector.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/box_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

// What an audit of normals reads: points bucket by bucket, relative to the buckets' corners, and
// what lies around some of them.

inline constexpr std::size_t kAuditBucket = BoxTree::kBucket;

inline constexpr float kNowhere = 1e30f;  ///< of padding: in no ball

/// A bucket's points relative to the low corner of its box, and their normals, as flat arrays:
/// ready to be moved to the origin of any bucket near.
struct alignas(64) LocalBucket {
    float x[kAuditBucket], y[kAuditBucket], z[kAuditBucket], nx[kAuditBucket], ny[kAuditBucket],
        nz[kAuditBucket];

    void set(const PointBlock& points, std::size_t begin, std::size_t end, const Vec3d& corner) {
        for (std::size_t k = 0; k < kAuditBucket; ++k) {
            const bool is_point = begin + k < end;
            const Vec3f p =
                is_point ? to_float(points.position[begin + k] - corner) : Vec3f{kNowhere};
            const Vec3f n = is_point ? points.normal[begin + k] : Vec3f{};
            x[k] = p.x, y[k] = p.y, z[k] = p.z;
            nx[k] = n.x, ny[k] = n.y, nz[k] = n.z;
        }
    }
};

/// The points of an audit: tree and local buckets. 24 bytes a point.
struct Neighborhoods {
    const BoxTree& tree;
    UnfilledVector<LocalBucket> buckets;

    Neighborhoods(const PointBlock& points, const BoxTree& boxes)
        : tree(boxes), buckets(tree.n_buckets()) {
        parallel_blocks(buckets.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b)
                buckets[b].set(points, b * kAuditBucket,
                               std::min((b + 1) * kAuditBucket, points.size()), tree.bucket(b).lo);
        });
    }
};

inline FloatV audit_lanes(const float* values) { return FloatV(values, stdx::element_aligned); }

/// Gaps between [lo, hi] and intervals side by side; zero where they meet.
inline FloatV gap(const FloatV& lo, const FloatV& hi, float from, float to) {
    return stdx::max(stdx::max(lo - to, from - hi), FloatV(0));
}

/// A box in floats, relative to an origin near it.
struct LocalBox {
    Vec3f lo, hi;
};

/// The buckets around some points: found with one walk for up to eight buckets of them.
class Surroundings {
public:
    void gather(const Neighborhoods& all, const Bbox& box, double radius) {
        n_ = 0;
        origin_ = box.lo;
        margin_ = static_cast<float>(kRounding * (box.diagonal() + radius));
        all.tree.for_buckets_near(box, radius, [&](std::size_t begin, std::size_t) {
            if (n_ + kLanes > bucket_.size()) grow();
            const LocalBox near = local(all.tree.bucket(begin / kAuditBucket));
            bucket_[n_] = static_cast<std::uint32_t>(begin / kAuditBucket);
            // All of them are read soon, from anywhere in memory.
            const char* points = reinterpret_cast<const char*>(&all.buckets[bucket_[n_]]);
            for (std::size_t line = 0; line < sizeof(LocalBucket); line += 64)
                __builtin_prefetch(points + line);
            for (std::size_t axis = 0; axis < 3; ++axis)
                lo_[axis][n_] = near.lo[axis], hi_[axis][n_] = near.hi[axis];
            ++n_;
        });
        for (std::size_t k = n_; k % kLanes != 0; ++k) lo_[0][k] = hi_[0][k] = kNowhere;
    }

    /// Calls body(bucket) for every bucket whose box is nearer to a part of the box than the
    /// radius, in order; for some that are as far but for rounding, too.
    template <class Body>
    void for_buckets_near(const Bbox& part, double radius, Body&& body) const {
        const LocalBox box = local(part);
        const float reach = static_cast<float>(radius) + margin_;
        for (std::size_t first = 0; first < n_; first += kLanes)
            for (std::uint64_t bits = near_bits(first, box, reach * reach); bits != 0;
                 bits &= bits - 1)
                body(bucket_[first + static_cast<std::size_t>(std::countr_zero(bits))]);
    }

private:
    static constexpr double kRounding = 1e-6;  // of floats, with room to spare

    /// Which of the boxes from the first on are near.
    [[gnu::flatten]] std::uint64_t near_bits(std::size_t first, const LocalBox& box,
                                             float sq_reach) const {
        FloatV sq = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const FloatV d = gap(audit_lanes(&lo_[axis][first]), audit_lanes(&hi_[axis][first]),
                                 box.lo[axis], box.hi[axis]);
            sq += d * d;
        }
        return lane_bits(sq < FloatV(sq_reach));
    }
    LocalBox local(const Bbox& box) const {
        return {to_float(box.lo - origin_), to_float(box.hi - origin_)};
    }
    void grow() {
        bucket_.resize(2 * bucket_.size() + 256);
        for (auto* a : {&lo_, &hi_})
            for (std::vector<float>& values : *a) values.resize(bucket_.size());
    }

    Vec3d origin_;
    float margin_ = 0;
    std::vector<std::uint32_t> bucket_;
    std::array<std::vector<float>, 3> lo_, hi_;  // padded with boxes that are nowhere
    std::size_t n_ = 0;
};

/// The points nearer to a box than the radius, relative to its low corner, as flat arrays.
struct Candidates {
    std::vector<float> x, y, z, nx, ny, nz;
    std::size_t n = 0;

    void clear() { n = 0; }
    /// Makes the last lanes whole with points that are in no ball. Call when all are added.
    void pad() {
        if (n + kLanes > x.size()) grow();
        std::fill_n(&x[n], kLanes, kNowhere);
    }

    /// shift: of the bucket's corner from the box's; extent: of the box
    [[gnu::flatten]] void add(const LocalBucket& bucket, const Vec3f& shift, const Vec3f& extent,
                              float sq_radius) {
        if (n + kAuditBucket > x.size()) grow();
        for (std::size_t k = 0; k < kAuditBucket; k += kLanes) {
            const FloatV px = audit_lanes(bucket.x + k) + shift.x,
                         py = audit_lanes(bucket.y + k) + shift.y,
                         pz = audit_lanes(bucket.z + k) + shift.z;
            const FloatV dx = gap(px, px, 0, extent.x), dy = gap(py, py, 0, extent.y),
                         dz = gap(pz, pz, 0, extent.z);
            const std::uint64_t near = lane_bits(dx * dx + dy * dy + dz * dz < FloatV(sq_radius));
            compress_to(px, near, &x[n]), compress_to(py, near, &y[n]),
                compress_to(pz, near, &z[n]);
            compress_to(audit_lanes(bucket.nx + k), near, &nx[n]);
            compress_to(audit_lanes(bucket.ny + k), near, &ny[n]);
            compress_to(audit_lanes(bucket.nz + k), near, &nz[n]);
            n += static_cast<std::size_t>(std::popcount(near));
        }
    }

private:
    void grow() {
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz}) a->resize(2 * a->size() + 512);
    }
};

}  // namespace slim
