#include "slim/blend/shape_field.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace slim {
namespace {

constexpr double kSteepest = 0.6;
constexpr double kMeanSquare = 0.12029;  // of r / rho under G on the plane (NUMERICS 2.3)

/// What the shortest turn from the normal of a height field's plane to that of its surface, where
/// the slopes are P_u and P_v, makes of vectors: unit tangents there are M^-1 of unit vectors in
/// the plane, M = 1 + p p^T / (1 + |g|), |g|^2 = 1 + p^2. So the shape operator S and the second
/// derivatives P'' belong to each other by P'' = |g| M S M.
/// Slopes count up to kSteepest: steeper ones are where a polynomial runs out of its data beside a
/// crease, and |g|^3 would make spots of the other sign of them.
struct Slant {
    double size;           ///< |g|
    double uu, uv, vv;     ///< M

    Slant(double p_u, double p_v) {
        const double steep = std::hypot(p_u, p_v);
        if (steep > kSteepest) p_u *= kSteepest / steep, p_v *= kSteepest / steep;
        size = std::sqrt(1 + p_u * p_u + p_v * p_v);
        const double share = 1 / (1 + size);
        uu = 1 + share * p_u * p_u, uv = share * p_u * p_v, vv = 1 + share * p_v * p_v;
    }

    PlanarTensor<2> hessian(const PlanarTensor<2>& shape) const {
        return between(uu, uv, vv, size, shape);
    }
    /// The determinant of M is |g|.
    PlanarTensor<2> shape(const PlanarTensor<2>& hessian) const {
        return between(vv / size, -uv / size, uu / size, 1 / size, hessian);
    }

private:
    /// scale m x m for symmetric m.
    static PlanarTensor<2> between(double m_uu, double m_uv, double m_vv, double scale,
                                   const PlanarTensor<2>& x) {
        const double a_uu = m_uu * x[0] + m_uv * x[1], a_uv = m_uu * x[1] + m_uv * x[2];
        const double a_vu = m_uv * x[0] + m_vv * x[1], a_vv = m_uv * x[1] + m_vv * x[2];
        return {scale * (a_uu * m_uu + a_uv * m_uv), scale * (a_uu * m_uv + a_uv * m_vv),
                scale * (a_vu * m_uv + a_vv * m_vv)};
    }
};

Slant slant_at(const Polynomial<double>& p, double u, double v) {
    return {p.d_u(u, v), p.d_v(u, v)};
}

PlanarTensor<2> shape_at(const Polynomial<double>& p, double u, double v) {
    return slant_at(p, u, v).shape({p.d_uu(u, v), p.d_uv(u, v), p.d_vv(u, v)});
}

PlanarTensor<2> value(const ShapeField& f, double u, double v) {
    PlanarTensor<2> out = times<3>(f.slopes, u, v);
    for (std::size_t k = 0; k < 3; ++k) out[k] += f.mean[k];
    return out;
}

}  // namespace

PlanarTensor<2> mean_shape_of(const Polynomial<double>& p) {
    static const double r = std::sqrt(kMeanSquare);
    PlanarTensor<2> out{};
    for (const auto& [u, v] : {std::pair{r, 0.0}, {-r, 0.0}, {0.0, r}, {0.0, -r}}) {
        const PlanarTensor<2> shape = shape_at(p, u, v);
        for (std::size_t k = 0; k < 3; ++k) out[k] += shape[k] / 4;
    }
    return out;
}

HeightHessian hessian_of(const ShapeField& shape, const Polynomial<double>& p) {
    static const double a = std::sqrt(3.0) / 4;  // G falls as exp(-8 r^2)
    const auto at = [&](double u, double v) {
        return slant_at(p, u, v).hessian(value(shape, u, v));
    };
    const PlanarTensor<2> middle = at(0, 0), right = at(a, 0), left = at(-a, 0), up = at(0, a),
                          down = at(0, -a), right_up = at(a, a), right_down = at(a, -a),
                          left_up = at(-a, a), left_down = at(-a, -a);
    HeightHessian out;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto put = [&](std::size_t i, double x) { out.c[k][i] = static_cast<float>(x); };
        put(0, middle[k]);
        put(1, (right[k] - left[k]) / (2 * a));
        put(2, (up[k] - down[k]) / (2 * a));
        put(3, (right[k] + left[k] - 2 * middle[k]) / (2 * a * a));
        put(4, (right_up[k] - right_down[k] - left_up[k] + left_down[k]) / (4 * a * a));
        put(5, (up[k] + down[k] - 2 * middle[k]) / (2 * a * a));
    }
    return out;
}

}  // namespace slim
