#include "slim/blend/shape_field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace slim {
namespace {

/// The quartic of a sphere's cap, radius 1 / k in units of rho: w = -(k r^2 / 2 + k^3 r^4 / 8).
std::array<double, 3> cap_derivatives(double k, double u, double v) {
    const double r2 = u * u + v * v;
    return {-k - k * k * k * (r2 + 2 * u * u) / 2, -k * k * k * u * v,
            -k - k * k * k * (r2 + 2 * v * v) / 2};
}

Polynomial<double> paraboloid(double k) {
    Polynomial<double> p;
    p.a[3] = p.a[5] = -k / 2;
    return p;
}

TEST(ShapeField, OfALevelPlaceIsTheSecondDerivatives) {
    Polynomial<double> p;
    p.a[3] = 0.02, p.a[4] = -0.01, p.a[5] = 0.03;  // slopes of 0.02 at the most: cosines are 1
    const PlanarTensor<2> mean = mean_shape_of(p);
    EXPECT_NEAR(mean[0], 0.04, 1e-4);
    EXPECT_NEAR(mean[1], -0.01, 1e-4);
    EXPECT_NEAR(mean[2], 0.06, 1e-4);
}

TEST(ShapeField, MakesOfAParaboloidTheSphereThatItWasFittedTo) {
    // A quadric fitted to a cap is steeper than it in the middle: by the r^4 term's part along r^2.
    const double k = 0.35, k3 = k * k * k;
    const double r2 = 0.12029, r4 = 0.027484, r6 = 0.0088068;  // NUMERICS 2.3
    const double along = (r6 - r2 * r4) / (r4 - r2 * r2);
    const Polynomial<double> fitted = paraboloid(k + 2 * k3 / 8 * along);
    const HeightHessian h = hessian_of({mean_shape_of(fitted), {}}, fitted);
    double sq = 0, sq_plain = 0;
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, {0.3, 0.1}, {-0.2, 0.45}, {0.5, 0.4}}) {
        const auto got = h.at(u, v), truth = cap_derivatives(k, u, v);
        const std::array<double, 3> plain{fitted.d_uu(u, v), fitted.d_uv(u, v), fitted.d_vv(u, v)};
        for (std::size_t i = 0; i < 3; ++i) {
            sq += (got[i] - truth[i]) * (got[i] - truth[i]);
            sq_plain += (plain[i] - truth[i]) * (plain[i] - truth[i]);
        }
    }
    EXPECT_LT(std::sqrt(sq), 0.25 * std::sqrt(sq_plain));
}

TEST(ShapeField, SteepRimsMakeNoSpotsOfTheOtherSign) {
    Polynomial<double> p;  // a leaf beside a crease: slopes of 2 at its rim
    p.a[1] = 0.5, p.a[3] = 0.8;
    const HeightHessian h = hessian_of({mean_shape_of(p), {}}, p);
    for (const double u : {-0.8, -0.4, 0.0, 0.4, 0.8}) {
        EXPECT_GT(h.at(u, 0.0)[0], 0);
        EXPECT_LT(h.at(u, 0.0)[0], 2.5 * p.d_uu(u, 0.0));
    }
}

TEST(ShapeField, SlopesShowInSecondDerivatives) {
    const ShapeField shape{{0.01, 0, -0.02}, {0.03, -0.01, 0.02, 0.04}};
    const HeightHessian h = hessian_of(shape, {});  // flat: the shape operator itself
    const double u = 0.4, v = -0.2;
    const auto at = h.at(u, v);
    EXPECT_NEAR(at[0], 0.01 + 0.03 * u - 0.01 * v, 1e-6);
    EXPECT_NEAR(at[1], -0.01 * u + 0.02 * v, 1e-6);
    EXPECT_NEAR(at[2], -0.02 + 0.02 * u + 0.04 * v, 1e-6);
}

}  // namespace
}  // namespace slim
