#include "slim/model/height_hessian.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

TEST(HeightHessian, OfAPolynomialIsItsOwn) {
    Polynomial<double> p;
    for (std::size_t k = 0; k < p.a.size(); ++k) p.a[k] = 0.1 * static_cast<double>(k * k) - 1.3;
    const HeightHessian h = hessian_of(p);
    const double u = 0.3, v = -0.7;
    const auto at = h.at(u, v);
    EXPECT_NEAR(at[0], p.d_uu(u, v), 1e-5);
    EXPECT_NEAR(at[1], p.d_uv(u, v), 1e-5);
    EXPECT_NEAR(at[2], p.d_vv(u, v), 1e-5);
}

TEST(HeightHessian, EachEntryIsAPolynomialOfItsOwn) {
    const HeightHessian h{{{{1, 2, 3, 4, 5, 6}, {-1, 0, 0, 0, 2, 0}, {0, 0, 7, 0, 0, -1}}}};
    const double u = 0.5, v = -0.25;
    const auto at = h.at(u, v);
    EXPECT_DOUBLE_EQ(at[0], 1 + 2 * u + 3 * v + 4 * u * u + 5 * u * v + 6 * v * v);
    EXPECT_DOUBLE_EQ(at[1], -1 + 2 * u * v);
    EXPECT_DOUBLE_EQ(at[2], 7 * v - v * v);
    EXPECT_FLOAT_EQ(h.at(0.5f, -0.25f)[0], static_cast<float>(at[0]));
}

}  // namespace
}  // namespace slim
