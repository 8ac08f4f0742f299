#pragma once

#include "raytrace/project/screen_rect.h"

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Bits of a float as an integer of the same order.
inline std::uint32_t ordered_bits(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// The entries with a rectangle in stable order of their keys: least significant digit first,
/// 11 bits at a time.
inline std::vector<std::uint32_t> sorted_order(std::span<const std::uint32_t> keys,
                                               std::span<const ScreenRect> rects) {
    constexpr int kBits = 11, kPasses = 3;
    constexpr std::uint32_t kDigits = 1u << kBits;
    const auto digit = [](std::uint32_t key, int pass) {
        return (key >> (kBits * pass)) & (kDigits - 1);
    };
    std::vector<std::uint32_t> order, start(kPasses * (kDigits + 1), 0);
    order.reserve(keys.size());
    for (std::uint32_t i = 0; i < keys.size(); ++i) {
        if (rects[i].empty()) continue;
        order.push_back(i);
        for (int pass = 0; pass < kPasses; ++pass)
            ++start[static_cast<std::uint32_t>(pass) * (kDigits + 1) + digit(keys[i], pass) + 1];
    }
    std::vector<std::uint32_t> other(order.size());
    for (int pass = 0; pass < kPasses; ++pass) {
        std::uint32_t* const next = start.data() + static_cast<std::uint32_t>(pass) * (kDigits + 1);
        for (std::uint32_t d = 0; d < kDigits; ++d) next[d + 1] += next[d];
        for (const std::uint32_t i : order) other[next[digit(keys[i], pass)]++] = i;
        order.swap(other);
    }
    return order;
}

}  // namespace slim
