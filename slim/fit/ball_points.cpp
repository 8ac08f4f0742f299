#include "slim/fit/ball_points.h"

#include <algorithm>
#include <bit>

namespace slim {
namespace {

template <class T>
void reserve_points(BallPoints<T>& out, std::size_t n) {
    if (out.x.size() >= n) return;
    const std::size_t size = n * 2;
    for (auto* a : {&out.x, &out.y, &out.z, &out.sq}) a->resize(size);
    for (auto* a : {&out.nx, &out.ny, &out.nz}) a->resize(size);
    out.index.resize(size);
}

template <class T>
void pad(BallPoints<T>& out) {
    reserve_points(out, out.n + stdx::native_simd<T>::size());
    for (std::size_t i = out.n; i < out.padded(); ++i) {
        out.x[i] = out.y[i] = out.z[i] = T(0);
        out.nx[i] = out.ny[i] = out.nz[i] = 0.0f;
        out.sq[i] = T(2);
        out.index[i] = 0;
    }
}

using DoubleV = stdx::native_simd<double>;
constexpr std::size_t kBucket = PointBucket::kSize;

/// A bucket's points relative to a centre, times a scale.
struct alignas(64) Offsets {
    double x[kBucket], y[kBucket], z[kBucket], sq[kBucket];

    /// Returns bit i: point i is nearer than 1.
    std::uint32_t fill(const PointBucket& b, const Vec3d& c, double scale) {
        std::uint32_t inside = 0;
        for (std::size_t i = 0; i < kBucket; i += DoubleV::size()) {
            const DoubleV dx = (DoubleV(b.x + i, stdx::vector_aligned) - c.x) * scale;
            const DoubleV dy = (DoubleV(b.y + i, stdx::vector_aligned) - c.y) * scale;
            const DoubleV dz = (DoubleV(b.z + i, stdx::vector_aligned) - c.z) * scale;
            const DoubleV s = dx * dx + dy * dy + dz * dz;
            dx.copy_to(x + i, stdx::vector_aligned), dy.copy_to(y + i, stdx::vector_aligned);
            dz.copy_to(z + i, stdx::vector_aligned), s.copy_to(sq + i, stdx::vector_aligned);
            inside |= static_cast<std::uint32_t>(lane_bits(s < 1.0)) << i;
        }
        return inside;
    }
};

template <class T>
void take(const PointBucket& b, const Offsets& d, std::size_t i, std::size_t first, std::size_t n,
          BallPoints<T>& out) {
    out.x[n] = static_cast<T>(d.x[i]), out.y[n] = static_cast<T>(d.y[i]);
    out.z[n] = static_cast<T>(d.z[i]), out.sq[n] = static_cast<T>(d.sq[i]);
    out.nx[n] = b.nx[i], out.ny[n] = b.ny[i], out.nz[n] = b.nz[i];
    out.index[n] = static_cast<std::uint32_t>(first + i);
}

}  // namespace

template <class T>
void gather_ball(const PointTree& tree, const Vec3d& c, double radius, BallPoints<T>& out) {
    out.n = 0;
    out.radius = radius;
    Offsets offsets;
    // Centred in doubles, then scaled.
    tree.for_buckets_in_ball(c, radius, [&](std::size_t first, const PointBucket& bucket) {
        std::uint32_t inside = offsets.fill(bucket, c, 1 / radius);
        if (inside == 0) return;
        reserve_points(out, out.n + kBucket);
        for (; inside != 0; inside &= inside - 1)
            take(bucket, offsets, static_cast<std::size_t>(std::countr_zero(inside)), first,
                 out.n++, out);
    });
    pad(out);
}

template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<float>&);
template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<double>&);

void list_sq_distances(const PointTree& tree, const Vec3d& c, double radius,
                       std::vector<double>& out) {
    out.clear();
    const double sq_radius = radius * radius;
    Offsets offsets;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t, const PointBucket& bucket) {
        offsets.fill(bucket, c, 1);
        for (const double sq : offsets.sq)
            if (sq < sq_radius) out.push_back(sq);
    });
}

std::size_t count_in_ball(const PointTree& tree, const Vec3d& c, double radius,
                          std::size_t enough) {
    std::size_t n = 0;
    Offsets offsets;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t, const PointBucket& bucket) {
        if (n < enough)
            n += static_cast<std::size_t>(std::popcount(offsets.fill(bucket, c, 1 / radius)));
    });
    return std::min(n, enough);
}

}  // namespace slim
