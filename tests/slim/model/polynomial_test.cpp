#include "slim/model/polynomial.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

TEST(Polynomial, RescaledIsTheSameHeightField) {
    Polynomial<double> p;
    for (std::size_t k = 0; k < p.a.size(); ++k) p.a[k] = 0.3 + 0.1 * static_cast<double>(k);
    constexpr double kRadius = 2, kRatio = 1.7;
    const Polynomial<double> q = rescaled(p, kRatio);
    for (const double x : {-0.8, 0.1, 0.6})
        for (const double y : {-0.3, 0.9})
            EXPECT_NEAR(q.value(x / (kRadius * kRatio), y / (kRadius * kRatio)) * kRadius * kRatio,
                        p.value(x / kRadius, y / kRadius) * kRadius, 1e-12);
}

}  // namespace
}  // namespace slim
