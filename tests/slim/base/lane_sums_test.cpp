#include "slim/base/lane_sums.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace slim {
namespace {

/// Values of very different sizes: their sums depend on the order.
template <class V, std::size_t N>
std::array<V, N> uneven_values() {
    std::array<V, N> values;
    std::uint64_t n = 0;
    for (V& v : values)
        v = V([&](auto) {
            const std::uint64_t bits = keyed_hash(1, ++n, 2);
            const double fraction = static_cast<double>(bits >> 11) * 0x1.0p-53 - 0.5;
            return static_cast<typename V::value_type>(
                std::ldexp(fraction, static_cast<int>(bits % 40)));
        });
    return values;
}

template <class V>
void expect_same_sums() {
    const auto values = uneven_values<V, 24>();
    const auto sums = lane_sums(values);
    for (std::size_t k = 0; k < values.size(); ++k) EXPECT_EQ(sums[k], lane_sum(values[k])) << k;
}

TEST(LaneSums, OfManyAreThoseOfEachToTheLastBit) {
    expect_same_sums<FloatV>();
    expect_same_sums<stdx::native_simd<double>>();
}

TEST(LaneSums, AreSumsOfAllLanes) {
    std::array<FloatV, 8> values;
    for (std::size_t k = 0; k < 8; ++k)
        values[k] = FloatV([&](auto lane) { return static_cast<float>(100 * k + lane); });
    const auto sums = lane_sums(values);
    constexpr double n = kLanes;
    for (std::size_t k = 0; k < 8; ++k)
        EXPECT_EQ(sums[k], 100.0 * static_cast<double>(k) * n + n * (n - 1) / 2);
}

}  // namespace
}  // namespace slim
