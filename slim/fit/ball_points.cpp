#include "slim/fit/ball_points.h"

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

}  // namespace

template <class T>
void gather_ball(const PointTree& tree, const Vec3d& c, double radius, BallPoints<T>& out) {
    out.n = 0;
    out.radius = radius;
    const double scale = 1 / radius;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t begin, std::size_t end) {
        reserve_points(out, out.n + (end - begin) + 1);
        std::size_t n = out.n;
        for (std::size_t i = begin; i < end; ++i) {
            // Written at the end, kept only if inside: no branch. Centred in doubles, then scaled.
            const double dx = (tree.x()[i] - c.x) * scale;
            const double dy = (tree.y()[i] - c.y) * scale;
            const double dz = (tree.z()[i] - c.z) * scale;
            const double sq = dx * dx + dy * dy + dz * dz;
            out.x[n] = static_cast<T>(dx), out.y[n] = static_cast<T>(dy);
            out.z[n] = static_cast<T>(dz), out.sq[n] = static_cast<T>(sq);
            out.nx[n] = tree.nx()[i], out.ny[n] = tree.ny()[i], out.nz[n] = tree.nz()[i];
            out.index[n] = static_cast<std::uint32_t>(i);
            n += sq < 1 ? 1u : 0u;
        }
        out.n = n;
    });
    pad(out);
}

template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<float>&);
template void gather_ball(const PointTree&, const Vec3d&, double, BallPoints<double>&);

void list_sq_distances(const PointTree& tree, const Vec3d& c, double radius,
                       std::vector<double>& out) {
    out.clear();
    const double sq_radius = radius * radius;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t begin, std::size_t end) {
        std::size_t n = out.size();
        out.resize(n + (end - begin));
        for (std::size_t i = begin; i < end; ++i) {
            const double sq = sq_length(tree.position(i) - c);
            out[n] = sq;
            n += sq < sq_radius ? 1u : 0u;
        }
        out.resize(n);
    });
}

std::size_t count_in_ball(const PointTree& tree, const Vec3d& c, double radius,
                          std::size_t enough) {
    std::size_t n = 0;
    const double sq_radius = radius * radius;
    tree.for_buckets_in_ball(c, radius, [&](std::size_t begin, std::size_t end) {
        if (n >= enough) return;
        for (std::size_t i = begin; i < end; ++i)
            n += sq_length(tree.position(i) - c) < sq_radius ? 1u : 0u;
    });
    return n < enough ? n : enough;
}

}  // namespace slim
