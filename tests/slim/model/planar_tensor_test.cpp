#include "slim/model/planar_tensor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

/// The tensor with all its places taken by (u, v).
double form(const PlanarTensor<3>& s, double u, double v) {
    return times<1>(times<2>(times<3>(s, u, v), u, v), u, v)[0];
}

TEST(PlanarTensor, AFormIsTheSumOfItsEntriesEachAsOftenAsItStands) {
    const PlanarTensor<3> s{0.7, -1.1, 0.4, 2.3};
    const double u = 0.6, v = -1.7;
    double sum = 0;
    for (std::size_t k = 0; k <= 3; ++k)
        sum += n_times(3, k) * s[k] * std::pow(u, 3 - static_cast<double>(k)) *
               std::pow(v, static_cast<double>(k));
    EXPECT_NEAR(form(s, u, v), sum, 1e-12);
    EXPECT_EQ(n_times(3, 0), 1);
    EXPECT_EQ(n_times(3, 1), 3);
    EXPECT_EQ(n_times(4, 2), 6);
}

TEST(PlanarTensor, TurnedItSaysTheSameOfTheSamePlace) {
    const PlanarTensor<3> s{0.7, -1.1, 0.4, 2.3};
    const double c = std::cos(0.8), d = std::sin(0.8);
    // The axes of s are (c, d) and (-d, c) in the new ones.
    const PlanarTensor<3> there = turned<3>(s, {c, -d, d, c});
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, {0.3, -2.0}, {-1.2, 0.5}})
        EXPECT_NEAR(form(there, x, y), form(s, c * x + d * y, -d * x + c * y), 1e-12);
}

}  // namespace
}  // namespace slim
