#include "slim/fit/ball_points.h"

#include <algorithm>
#include <bit>
#include <type_traits>

namespace slim {
namespace {

/// Only exact fits ask which points they are.
template <class T>
constexpr bool kHasIndex = std::is_same_v<T, double>;

template <class T>
void reserve_points(BallPoints<T>& out, std::size_t n) {
    if (out.x.size() >= n) return;
    const std::size_t size = n * 2;
    for (auto* a : {&out.x, &out.y, &out.z, &out.sq}) a->resize(size);
    for (auto* a : {&out.nx, &out.ny, &out.nz}) a->resize(size);
    if constexpr (kHasIndex<T>) out.index.resize(size);
}

template <class T>
void pad(BallPoints<T>& out) {
    reserve_points(out, out.n + stdx::native_simd<T>::size());
    for (std::size_t i = out.n; i < out.padded(); ++i) {
        out.x[i] = out.y[i] = out.z[i] = T(0);
        out.nx[i] = out.ny[i] = out.nz[i] = 0.0f;
        out.sq[i] = T(2);
        if constexpr (kHasIndex<T>) out.index[i] = 0;
    }
}

using DoubleV = stdx::native_simd<double>;
constexpr std::size_t kGroup = DoubleV::size();
constexpr std::size_t kBucket = PointBucket::kSize;

/// A group of a bucket's points relative to a centre, times a scale.
struct Offsets {
    DoubleV x, y, z, sq;

    Offsets(const PointBucket& b, std::size_t i, const Vec3d& c, double scale)
        : x((DoubleV(b.x + i, stdx::vector_aligned) - c.x) * scale),
          y((DoubleV(b.y + i, stdx::vector_aligned) - c.y) * scale),
          z((DoubleV(b.z + i, stdx::vector_aligned) - c.z) * scale),
          sq(x * x + y * y + z * z) {}
};

/// Adds the points of a group whose bits are set; `first` is the index of its first in the tree.
void take(const PointBucket& b, std::size_t i, const Offsets& d, std::uint64_t inside,
          std::size_t first, BallPoints<double>& out) {
    const auto put = [&](const DoubleV& from, std::vector<double>& to) {
        compress_to<double>(from, inside, &to[out.n]);
    };
    const auto copy = [&](const float* from, std::vector<float>& to) {
        compress_to<float>(LanesOfDouble<float>(from + i, stdx::vector_aligned), inside, &to[out.n]);
    };
    put(d.x, out.x), put(d.y, out.y), put(d.z, out.z), put(d.sq, out.sq);
    copy(b.nx, out.nx), copy(b.ny, out.ny), copy(b.nz, out.nz);
    const LanesOfDouble<std::uint32_t> index([&](auto lane) {
        return static_cast<std::uint32_t>(first + i + lane);
    });
    compress_to<std::uint32_t>(index, inside, &out.index[out.n]);
    out.n += static_cast<std::size_t>(std::popcount(inside));
}

/// Adds a bucket's points in the ball, by groups of doubles.
void add_bucket(const PointBucket& b, const Vec3d& c, std::size_t first, BallPoints<double>& out) {
    for (std::size_t i = 0; i < kBucket; i += kGroup) {
        const Offsets offsets(b, i, c, 1 / out.radius);
        const std::uint64_t inside = lane_bits(offsets.sq < 1.0);
        if (inside != 0) take(b, i, offsets, inside, first, out);
    }
}

/// The same by groups of floats, two of doubles each: half the stores. No index is kept.
void add_bucket(const PointBucket& b, const Vec3d& c, std::size_t, BallPoints<float>& out) {
    const double scale = 1 / out.radius;
    const auto offset = [&](const double* from, double center) {
        const auto part = [&](std::size_t i) {
            return stdx::static_simd_cast<LanesOfDouble<float>>(
                (DoubleV(from + i, stdx::vector_aligned) - center) * scale);
        };
        return FloatV(stdx::concat(part(0), part(kGroup)));
    };
    for (std::size_t i = 0; i < kBucket; i += FloatV::size()) {
        const FloatV x = offset(b.x + i, c.x), y = offset(b.y + i, c.y), z = offset(b.z + i, c.z);
        const FloatV sq = x * x + y * y + z * z;
        const std::uint64_t inside = lane_bits(sq < 1.0f);
        if (inside == 0) continue;
        const auto copy = [&](const float* from, std::vector<float>& to) {
            compress_to(FloatV(from + i, stdx::vector_aligned), inside, &to[out.n]);
        };
        compress_to(x, inside, &out.x[out.n]), compress_to(y, inside, &out.y[out.n]);
        compress_to(z, inside, &out.z[out.n]), compress_to(sq, inside, &out.sq[out.n]);
        copy(b.nx, out.nx), copy(b.ny, out.ny), copy(b.nz, out.nz);
        out.n += static_cast<std::size_t>(std::popcount(inside));
    }
}

}  // namespace

template <class T>
void gather_ball(const PointTree& tree, const Vec3d& c, double radius, BallPoints<T>& out) {
    out.n = 0;
    out.radius = radius;
    // Centred in doubles, then scaled.
    tree.for_buckets_in_ball(c, radius, [&](std::size_t first, const PointBucket& bucket) {
        reserve_points(out, out.n + 2 * kBucket);
        add_bucket(bucket, c, first, out);
    });
    pad(out);
}

template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<float>&);
template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<double>&);

void list_sq_distances(const PointTree& tree, const Vec3d& c, double radius,
                       std::vector<double>& out) {
    const double sq_radius = radius * radius;
    std::size_t n = 0;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t, const PointBucket& bucket) {
        if (out.size() < n + 2 * kBucket) out.resize(2 * (n + 2 * kBucket));
        for (std::size_t i = 0; i < kBucket; i += kGroup) {
            const Offsets offsets(bucket, i, c, 1);
            const std::uint64_t inside = lane_bits(offsets.sq < sq_radius);
            compress_to<double>(offsets.sq, inside, &out[n]);
            n += static_cast<std::size_t>(std::popcount(inside));
        }
    });
    out.resize(n);
}

std::size_t count_in_ball(const PointTree& tree, const Vec3d& c, double radius,
                          std::size_t enough) {
    std::size_t n = 0;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t, const PointBucket& bucket) {
        for (std::size_t i = 0; i < kBucket && n < enough; i += kGroup)
            n += static_cast<std::size_t>(stdx::popcount(Offsets(bucket, i, c, 1 / radius).sq < 1.0));
    });
    return std::min(n, enough);
}

}  // namespace slim
