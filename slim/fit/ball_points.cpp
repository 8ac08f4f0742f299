#include "slim/fit/ball_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
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

constexpr std::size_t kBucket = PointBucket::kSize;

/// As many points of a bucket as V has lanes, relative to a centre, times a scale. How far the
/// centre is from the bucket is taken in doubles.
template <class V>
struct Offsets {
    using T = typename V::value_type;
    Vec3<V> d;
    V sq;

    Offsets(const PointBucket& b, std::size_t i, const Vec3d& center, double scale) {
        const Vec3d from = (center - b.origin) * scale;
        const auto axis = [&](const float* p, double c) {
            using Packed = stdx::rebind_simd_t<float, V>;
            return stdx::static_simd_cast<V>(Packed(p + i, stdx::element_aligned)) *
                       static_cast<T>(scale) -
                   static_cast<T>(c);
        };
        set({axis(b.x, from.x), axis(b.y, from.y), axis(b.z, from.z)});
    }
    /// The same by the positions of the block, from the first-th of the tree on.
    Offsets(const PointTree& tree, std::size_t first, const Vec3d& center, double scale) {
        std::array<T, V::size()> x, y, z;
        x.fill(std::numeric_limits<T>::infinity()), y = x, z = x;
        for (std::size_t k = 0; k < V::size() && first + k < tree.size(); ++k) {
            const Vec3d from = (tree.position(first + k) - center) * scale;
            x[k] = static_cast<T>(from.x), y[k] = static_cast<T>(from.y),
            z[k] = static_cast<T>(from.z);
        }
        const auto lanes = [](const std::array<T, V::size()>& a) {
            return V(a.data(), stdx::element_aligned);
        };
        set({lanes(x), lanes(y), lanes(z)});
    }

private:
    void set(const Vec3<V>& offset) {
        d = offset;
        sq = d.x * d.x + d.y * d.y + d.z * d.z;
    }
};

/// Lanes of float for as many points as V has.
template <class V>
stdx::rebind_simd_t<float, V> normals_at(const std::int16_t* n) {
    using Packed = stdx::rebind_simd_t<std::int16_t, V>;
    using Floats = stdx::rebind_simd_t<float, V>;
    return stdx::static_simd_cast<Floats>(Packed(n, stdx::element_aligned)) *
           (1 / PointBucket::kUnit);
}

constexpr std::uint64_t kWhole = ~std::uint64_t{0};

/// Puts those of a bucket's points that `wanted` names by bits in the ball behind the n that it
/// has, by groups; `first` is the index of its first in the tree. Returns how many there are now.
/// The ball's own n and arrays are not read between the stores.
template <class T>
std::size_t add_bucket(const PointTree& tree, const PointBucket& b, const Vec3d& c, double scale,
                       std::size_t first, std::uint64_t wanted, std::size_t n, BallPoints<T>& out) {
    using V = stdx::native_simd<T>;
    T *x = out.x.data(), *y = out.y.data(), *z = out.z.data(), *sq = out.sq.data();
    float *nx = out.nx.data(), *ny = out.ny.data(), *nz = out.nz.data();
    [[maybe_unused]] std::uint32_t* index = out.index.data();
    for (std::size_t i = 0; i < kBucket; i += V::size()) {
        const bool as_packed = !std::is_same_v<T, double> || b.is_exact;
        const Offsets<V> at =
            as_packed ? Offsets<V>(b, i, c, scale) : Offsets<V>(tree, first + i, c, scale);
        const std::uint64_t inside = lane_bits(at.sq < T(1)) & wanted >> i;
        if (inside == 0) continue;
        const auto put = [&]<class W, class U>(const W& from, U* to) {
            compress_to(from, inside, to + n);
        };
        put(at.d.x, x), put(at.d.y, y), put(at.d.z, z), put(at.sq, sq);
        put(normals_at<V>(b.nx + i), nx), put(normals_at<V>(b.ny + i), ny),
            put(normals_at<V>(b.nz + i), nz);
        if constexpr (kHasIndex<T>)
            put(LanesOfDouble<std::uint32_t>(
                    [&](auto lane) { return static_cast<std::uint32_t>(first + i + lane); }),
                index);
        n += static_cast<std::size_t>(std::popcount(inside));
    }
    return n;
}

template <class T, class Wanted>
void gather(const PointTree& tree, const Vec3d& c, double radius, const Wanted& wanted,
            BallPoints<T>& out) {
    out.n = 0;
    out.radius = radius;
    tree.for_buckets_in_ball(c, radius,
                             [&, scale = 1 / radius](std::size_t first, const PointBucket& bucket) {
                                 const std::uint64_t bits = wanted(first);
                                 if (bits == 0) return;
                                 reserve_points(out, out.n + 2 * kBucket);
                                 out.n =
                                     add_bucket(tree, bucket, c, scale, first, bits, out.n, out);
                             });
    pad(out);
}

}  // namespace

template <class T>
void gather_ball(const PointTree& tree, const Vec3d& c, double radius, BallPoints<T>& out) {
    gather(tree, c, radius, [](std::size_t) { return kWhole; }, out);
}

void gather_wanted(const PointTree& tree, const Vec3d& c, double radius,
                   const WantedOfBucket& wanted, BallPoints<double>& out) {
    gather(tree, c, radius, wanted, out);
}

template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<float>&);
template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<double>&);

void gather_disc(const PointTree& tree, const Vec3d& c, const Vec3d& normal, double radius,
                 double ball_radius, float least_cos, BallPoints<float>& out) {
    out.n = 0;
    out.radius = radius;
    const double scale = 1 / radius;
    const auto sq_ball = static_cast<float>(ball_radius * ball_radius * scale * scale);
    const Vec3<FloatV> axis{FloatV(static_cast<float>(normal.x)),
                            FloatV(static_cast<float>(normal.y)),
                            FloatV(static_cast<float>(normal.z))};
    tree.for_buckets_in_ball(c, ball_radius, [&](std::size_t, const PointBucket& b) {
        reserve_points(out, out.n + 2 * kBucket);
        for (std::size_t i = 0; i < kBucket; i += FloatV::size()) {
            const Offsets<FloatV> at(b, i, c, scale);
            const FloatV off = dot(axis, at.d);
            const FloatV sq = stdx::max(at.sq - off * off, FloatV(0.0f));
            const Vec3<FloatV> n{normals_at<FloatV>(b.nx + i), normals_at<FloatV>(b.ny + i),
                                 normals_at<FloatV>(b.nz + i)};
            const auto measured = n.x != 0.0f || n.y != 0.0f || n.z != 0.0f;
            const auto contrary = measured && dot(axis, n) < least_cos;
            const std::uint64_t counts = lane_bits(at.sq < sq_ball && sq < 1.0f && !contrary);
            if (counts == 0) continue;
            const auto put = [&](const FloatV& from, std::vector<float>& to) {
                compress_to(from, counts, &to[out.n]);
            };
            put(at.d.x, out.x), put(at.d.y, out.y), put(at.d.z, out.z), put(sq, out.sq);
            put(n.x, out.nx), put(n.y, out.ny), put(n.z, out.nz);
            out.n += static_cast<std::size_t>(std::popcount(counts));
        }
    });
    pad(out);
}

template <class T>
void shrink_ball(const BallPoints<T>& ball, double radius, BallPoints<T>& out) {
    using V = stdx::native_simd<T>;
    using Floats = stdx::rebind_simd_t<float, V>;
    const auto factor = static_cast<T>(ball.radius / radius);
    const std::size_t end = ball.padded();
    reserve_points(out, end + V::size());
    out.radius = radius;
    std::size_t n = 0;
    for (std::size_t i = 0; i < end; i += V::size()) {
        const auto at = [&](const std::vector<T>& a) { return V(&a[i], stdx::element_aligned); };
        const V sq = at(ball.sq) * (factor * factor);
        const std::uint64_t inside = lane_bits(sq < T(1));
        const auto put = [&]<class W, class U>(const W& from, std::vector<U>& to) {
            compress_to(from, inside, &to[n]);
        };
        const auto put_normal = [&](const std::vector<float>& from, std::vector<float>& to) {
            put(Floats(&from[i], stdx::element_aligned), to);
        };
        put(at(ball.x) * factor, out.x), put(at(ball.y) * factor, out.y),
            put(at(ball.z) * factor, out.z);
        put(sq, out.sq);
        put_normal(ball.nx, out.nx), put_normal(ball.ny, out.ny), put_normal(ball.nz, out.nz);
        if constexpr (kHasIndex<T>)
            put(LanesOfDouble<std::uint32_t>(&ball.index[i], stdx::element_aligned), out.index);
        n += static_cast<std::size_t>(std::popcount(inside));
    }
    out.n = n;
    pad(out);
}

template void shrink_ball(const BallPoints<float>&, double, BallPoints<float>&);
template void shrink_ball(const BallPoints<double>&, double, BallPoints<double>&);

std::size_t count_in_ball(const PointTree& tree, const Vec3d& c, double radius,
                          std::size_t enough) {
    std::size_t n = 0;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t, const PointBucket& bucket) {
        for (std::size_t i = 0; i < kBucket && n < enough; i += FloatV::size())
            n += static_cast<std::size_t>(
                stdx::popcount(Offsets<FloatV>(bucket, i, c, 1 / radius).sq < 1.0f));
    });
    return std::min(n, enough);
}

}  // namespace slim
