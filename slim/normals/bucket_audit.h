#pragma once

#include "slim/base/simd.h"
#include "slim/normals/audit_buckets.h"
#include "slim/normals/repair.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace slim {

/// Cosine to the mean of the others below which a normal is looked at: the height-field limit of
/// the radius ladder.
inline constexpr double kNoisyNormal = 0.3;
inline constexpr float kLeastNeighbors = 5;
/// |cosine| of normals that are the same but for the sign.
inline constexpr float kAlongOneLine = 0.7f;
/// A bucket agrees by itself where |mean normal| and the least cosine to the mean of the others are
/// at least:
inline constexpr float kOfOneMind = 0.8f, kClose = 0.5f;

inline constexpr std::size_t kAuditGroups = kAuditBucket / kLanes;  ///< of lanes that hold a bucket
static_assert(kAuditBucket % kLanes == 0);

using BucketLanes = std::array<FloatV, kAuditGroups>;

inline BucketLanes lanes_of(const float (&values)[kAuditBucket]) {
    BucketLanes out;
    for (std::size_t g = 0; g < kAuditGroups; ++g) out[g] = audit_lanes(values + g * kLanes);
    return out;
}

/// Whether all points of a full bucket face as the mean of the others in it does, and clearly: no
/// look at what lies around is needed (notes/0001).
[[gnu::flatten]] inline bool is_of_one_mind(const LocalBucket& b) {
    FloatV sum[3] = {0, 0, 0};
    for (std::size_t k = 0; k < kAuditBucket; k += kLanes) {
        sum[0] += audit_lanes(b.nx + k);
        sum[1] += audit_lanes(b.ny + k);
        sum[2] += audit_lanes(b.nz + k);
    }
    const float x = stdx::reduce(sum[0]), y = stdx::reduce(sum[1]), z = stdx::reduce(sum[2]);
    constexpr float kLeast = kOfOneMind * kAuditBucket;
    if (!(x * x + y * y + z * z > kLeast * kLeast)) return false;
    for (std::size_t k = 0; k < kAuditBucket; k += kLanes) {
        const FloatV nx = audit_lanes(b.nx + k), ny = audit_lanes(b.ny + k),
                     nz = audit_lanes(b.nz + k);
        const FloatV mx = x - nx, my = y - ny, mz = z - nz;
        const FloatV along = mx * nx + my * ny + mz * nz;
        const FloatV sq_own = nx * nx + ny * ny + nz * nz, sq_mean = mx * mx + my * my + mz * mz;
        if (!stdx::all_of(along > FloatV(0) &&
                          along * along > FloatV(kClose * kClose) * sq_own * sq_mean))
            return false;
    }
    return true;
}

/// Whether a normal is within 72 degrees of the mean of the others, by more than rounding: from
/// their dot product and squared lengths, numbers or lanes.
template <class T>
auto do_agree(const T& along, const T& sq_own, const T& sq_mean) {
    constexpr float kAgree = static_cast<float>(kNoisyNormal) + 0.01f;
    return (along > T(0)) && (along * along > T(kAgree * kAgree) * sq_own * sq_mean);
}

/// Whether nothing is wrong with the k-th of some points, as Sixteen::agreeing() says of each: for
/// a few of them, a lane is a candidate (padded).
[[gnu::flatten]] inline bool agrees(const LocalBucket& own, std::size_t k, const Candidates& c,
                                    float sq_radius) {
    FloatV lanes[3] = {0, 0, 0};
    for (std::size_t i = 0; i < c.n; i += kLanes) {
        const FloatV dx = audit_lanes(&c.x[i]) - own.x[k], dy = audit_lanes(&c.y[i]) - own.y[k],
                     dz = audit_lanes(&c.z[i]) - own.z[k];
        const auto in = dx * dx + dy * dy + dz * dz < FloatV(sq_radius);
        lanes[0] += select(in, audit_lanes(&c.nx[i]), FloatV(0));
        lanes[1] += select(in, audit_lanes(&c.ny[i]), FloatV(0));
        lanes[2] += select(in, audit_lanes(&c.nz[i]), FloatV(0));
    }
    const Vec3f normal{own.nx[k], own.ny[k], own.nz[k]};
    const Vec3f mean =
        Vec3f{stdx::reduce(lanes[0]), stdx::reduce(lanes[1]), stdx::reduce(lanes[2])} - normal;
    return do_agree(dot(mean, normal), sq_length(normal), sq_length(mean));
}

/// Points of one bucket, a lane each, and what they find of the candidates within a radius. A
/// candidate is looked at by all of them at once: most are near to most.
struct Sixteen {
    BucketLanes x, y, z, nx, ny, nz;
    BucketLanes sum_x{}, sum_y{}, sum_z{}, count{};  // of normals within the radius

    explicit Sixteen(const LocalBucket& points)
        : x(lanes_of(points.x)), y(lanes_of(points.y)), z(lanes_of(points.z)),
          nx(lanes_of(points.nx)), ny(lanes_of(points.ny)), nz(lanes_of(points.nz)) {}

    [[gnu::flatten]] void sum_up(const Candidates& c, float sq_radius) {
        const FloatV zero = 0, one = 1;
        for (std::size_t g = 0; g < kAuditGroups; ++g) {
            // Copies, as the compiler keeps them in registers.
            const FloatV px = x[g], py = y[g], pz = z[g];
            FloatV sx = 0, sy = 0, sz = 0, n = 0;
            for (std::size_t k = 0; k < c.n; ++k) {
                const FloatV dx = c.x[k] - px, dy = c.y[k] - py, dz = c.z[k] - pz;
                const FloatV in =
                    select(dx * dx + dy * dy + dz * dz < FloatV(sq_radius), one, zero);
                sx += in * c.nx[k], sy += in * c.ny[k], sz += in * c.nz[k];
                n += in;
            }
            sum_x[g] = sx, sum_y[g] = sy, sum_z[g] = sz, count[g] = n;
        }
    }

    /// Bit k: the normal of the k-th is within 72 degrees of the mean of the others, by more than
    /// rounding: nothing is wrong with it.
    [[gnu::flatten]] std::uint64_t agreeing() const {
        std::uint64_t bits = 0;
        for (std::size_t g = 0; g < kAuditGroups; ++g) {
            const FloatV mx = sum_x[g] - nx[g], my = sum_y[g] - ny[g], mz = sum_z[g] - nz[g];
            const FloatV along = mx * nx[g] + my * ny[g] + mz * nz[g];
            const FloatV sq_own = nx[g] * nx[g] + ny[g] * ny[g] + nz[g] * nz[g];
            const FloatV sq_mean = mx * mx + my * my + mz * mz;
            bits |= lane_bits(do_agree(along, sq_own, sq_mean)) << (g * kLanes);
        }
        return bits;
    }

    [[gnu::flatten]] void compare_signs(const Candidates& c, float sq_radius,
                                        NormalAudit& audit) const {
        const FloatV zero = 0, one = 1;
        for (std::size_t g = 0; g < kAuditGroups; ++g) {
            FloatV opposed = 0, compared = 0, across = 0, across_size = 0;
            for (std::size_t k = 0; k < c.n; ++k) {
                const FloatV dx = c.x[k] - x[g], dy = c.y[k] - y[g], dz = c.z[k] - z[g];
                const auto in = dx * dx + dy * dy + dz * dz < FloatV(sq_radius);
                const FloatV cosine = nx[g] * c.nx[k] + ny[g] * c.ny[k] + nz[g] * c.nz[k];
                const FloatV height = nx[g] * dx + ny[g] * dy + nz[g] * dz;
                const auto is_opposed = in && cosine < FloatV(-kAlongOneLine);
                opposed += select(is_opposed, one, zero);
                compared += select(is_opposed || (in && cosine > FloatV(kAlongOneLine)), one, zero);
                across += select(is_opposed, height, zero);
                across_size += select(is_opposed, stdx::abs(height), zero);
            }
            audit.opposed += stdx::reduce(opposed);
            audit.compared += stdx::reduce(compared);
            audit.across += stdx::reduce(across);
            audit.across_size += stdx::reduce(across_size);
        }
    }

    /// Mean of the normals within the radius of the k-th, its own left out; zero if they are too
    /// few.
    Vec3d majority(std::size_t k) const {
        const std::size_t g = k / kLanes, lane = k % kLanes;
        const float n = count[g][lane];
        if (n < kLeastNeighbors + 1) return {};
        const Vec3d sum{sum_x[g][lane], sum_y[g][lane], sum_z[g][lane]};
        const Vec3d own{nx[g][lane], ny[g][lane], nz[g][lane]};
        return (sum - own) / static_cast<double>(n - 1);
    }
};

}  // namespace slim
