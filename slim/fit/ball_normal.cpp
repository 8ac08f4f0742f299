#include "slim/fit/ball_normal.h"

#include <Eigen/Eigenvalues>

#include <bit>
#include <cmath>

namespace slim {
namespace {

constexpr double kSideInDoubt = 0.6;  // cosine of the mean to the normal of the centre
constexpr double kLeastAgreement = 0.3;  // |sum G n| / sum G below which the normals disagree

template <class T>
Vec3d least_spread_direction(const BallPoints<T>& p, double shrink) {
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double weight = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (std::size_t i = 0; i < p.n; ++i) {
            const double g = fit_weight(p.weight, static_cast<double>(p.sq[i]) / (shrink * shrink));
            const Eigen::Vector3d x(p.x[i], p.y[i], p.z[i]);
            if (pass == 0)
                mean += g * x, weight += g;
            else
                covariance += g * (x - mean) * (x - mean).transpose();
        }
        if (pass == 0 && weight > 0) mean /= weight;
    }
    const Eigen::Vector3d n =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0);
    return {n.x(), n.y(), n.z()};
}

/// sum G n_i over the points on the side of `side`, and sum G; weights at |x| / shrink.
struct NormalSum {
    Vec3d sum;
    double weight;
};

template <class T>
NormalSum sum_on_side(const BallPoints<T>& p, double shrink, const Vec3d& side) {
    using V = stdx::native_simd<T>;
    const auto lanes = [](const auto& a, std::size_t i) { return V(&a[i], stdx::element_aligned); };
    const Vec3<V> s{V(T(side.x)), V(T(side.y)), V(T(side.z))};
    const V to_fit = V(T(1 / (shrink * shrink)));
    Vec3<V> lane_sum{V(T(0)), V(T(0)), V(T(0))};
    V lane_weight = T(0);
    for (std::size_t i = 0; i < p.padded(); i += V::size()) {
        const V nx = lanes(p.nx, i), ny = lanes(p.ny, i), nz = lanes(p.nz, i);
        const auto same = nx * s.x + ny * s.y + nz * s.z > T(0);
        const V g = select(same, fit_weight(p.weight, lanes(p.sq, i) * to_fit), V(T(0)));
        lane_sum.x += g * nx, lane_sum.y += g * ny, lane_sum.z += g * nz;
        lane_weight += g;
    }
    return {{stdx::reduce(lane_sum.x), stdx::reduce(lane_sum.y), stdx::reduce(lane_sum.z)},
            stdx::reduce(lane_weight)};
}

}  // namespace

template <class T>
[[gnu::flatten]] BallNormal average_normal(const BallPoints<T>& p, double shrink,
                                           const Vec3d& side) {
    NormalSum found = sum_on_side(p, shrink, side);
    double len = length(found.sum);
    const auto agree = [&] { return len > kLeastAgreement * found.weight && len > 0; };
    if (agree() && dot(found.sum, side) < kSideInDoubt * len * length(side)) {
        found = sum_on_side(p, shrink, found.sum / len);
        len = length(found.sum);
    }
    if (agree()) return {found.sum / len, false};
    const Vec3d known = sq_length(side) > 0 ? side : Vec3d{0, 0, 1};
    if (p.n < 3) return {known, true};
    const Vec3d n = least_spread_direction(p, shrink);
    return {dot(n, side) < 0 ? -n : n, true};
}

template <class T>
[[gnu::flatten]] void set_contrary_aside(BallPoints<T>& p, const Vec3d& normal,
                                         std::vector<SetAside<T>>& out) {
    using V = stdx::rebind_simd_t<float, stdx::native_simd<T>>;  // balls are padded to these
    const auto lanes = [](const std::vector<float>& a, std::size_t i) {
        return V(&a[i], stdx::element_aligned);
    };
    const Vec3f n = to_float(normal);
    out.clear();
    // Padding has no normal.
    for (std::size_t first = 0; first < p.padded(); first += V::size()) {
        const V nx = lanes(p.nx, first), ny = lanes(p.ny, first), nz = lanes(p.nz, first);
        const auto measured = nx != 0.0f || ny != 0.0f || nz != 0.0f;
        const auto contrary = measured && nx * n.x + ny * n.y + nz * n.z < kLeastCos;
        for (std::uint64_t bits = lane_bits(contrary); bits != 0; bits &= bits - 1) {
            const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(bits));
            out.push_back({i, p.sq[i]});
            p.sq[i] = T(2);
        }
    }
}

template BallNormal average_normal(const BallPoints<float>&, double, const Vec3d&);
template BallNormal average_normal(const BallPoints<double>&, double, const Vec3d&);
template void set_contrary_aside(BallPoints<float>&, const Vec3d&, std::vector<SetAside<float>>&);
template void set_contrary_aside(BallPoints<double>&, const Vec3d&, std::vector<SetAside<double>>&);

}  // namespace slim
