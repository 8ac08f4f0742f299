#include "raytrace/trace/two_floats.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

// Sums in two floats against doubles.

namespace slim {
namespace {

/// Floats of either sign and of sizes from 2^-12 to 2^12, so that doubles hold their sums.
FloatV numbers(std::uint64_t seed, std::uint64_t purpose) {
    return FloatV([&](auto k) {
        const auto at = [&](std::uint64_t i) {
            return unit_interval(keyed_hash(seed, k, 4 * purpose + i));
        };
        const double size = std::exp2(std::floor(24 * at(0)) - 12) * (1 + at(1));
        return static_cast<float>(at(2) < 0.5 ? -size : size);
    });
}

double value(const TwoFloats& v, std::size_t k) {
    return static_cast<double>(static_cast<float>(v.high[k])) +
           static_cast<double>(static_cast<float>(v.low[k]));
}
double value(const FloatV& v, std::size_t k) {
    return static_cast<double>(static_cast<float>(v[k]));
}

TEST(TwoFloats, SumsAndDifferencesOfFloatsAreExact) {
    int n_inexact = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const FloatV a = numbers(seed, 0), b = numbers(seed, 1), none(0.0f);
        const TwoFloats sum = sum_of({a, none}, {b, none}),
                        difference = sum_of({a, none}, {-b, none});
        for (std::size_t k = 0; k < FloatV::size(); ++k) {
            SCOPED_TRACE(seed);
            ASSERT_EQ(value(sum, k), value(a, k) + value(b, k));
            ASSERT_EQ(value(difference, k), value(a, k) - value(b, k));
            ASSERT_EQ(static_cast<float>(sum.high[k]),
                      static_cast<float>(value(a, k) + value(b, k)));
            n_inexact += static_cast<float>(sum.low[k]) != 0;
        }
    }
    EXPECT_GT(n_inexact, 50);  // one float would not do
}

// From far: near places of a ray 1e6 away, which a float knows to 0.06.
TEST(TwoFloats, PlacesOnARayAreExactToTheSecondFloat) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        SCOPED_TRACE(seed);
        const FloatV none(0.0f), t = 1e6f + numbers(seed, 0);
        const FloatV d = numbers(seed, 1) * (1.0f / 4096), d_low = d * 1e-8f, o = -1e6f * d,
                     o_low = o * 1e-8f;
        const TwoFloatVecs at = place_along({{o, none, none}, {o_low, none, none}},
                                            {{d, none, none}, {d_low, none, none}}, t);
        for (std::size_t k = 0; k < FloatV::size(); ++k) {
            const double exact =
                value(o, k) + value(o_low, k) + value(t, k) * (value(d, k) + value(d_low, k));
            // Some units of the second float of the largest term.
            ASSERT_NEAR(value({at.high.x, at.low.x}, k), exact,
                        std::exp2(-45) * std::abs(value(o, k)));
            ASSERT_EQ(value(at.high.y, k), 0);
        }
    }
}

TEST(TwoFloats, ScaledSumsKeepWhatCancels) {
    const FloatV none(0.0f), a(1.0f), a_low(3e-9f), b(-1.0f), b_low(-1e-9f);
    const TwoFloatVecs sum = scaled_sum({{a, none, none}, {a_low, none, none}},
                                        {{b, none, none}, {b_low, none, none}}, 1024.0f);
    EXPECT_NEAR(value({sum.high.x, sum.low.x}, 0), 1024 * 2e-9, 1e-12);
}

}  // namespace
}  // namespace slim
