#pragma once

#include <cstdint>

namespace slim {

/// Mixes 64 bits (finaliser of splitmix64, Steele et al. 2014): the only source of randomness in
/// the fit, keyed by what it is for, so that threads and slices cannot change an answer.
constexpr std::uint64_t mix64(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

constexpr std::uint64_t keyed_hash(std::uint64_t seed, std::uint64_t key) {
    return mix64(mix64(seed) ^ key);
}
constexpr std::uint64_t keyed_hash(std::uint64_t seed, std::uint64_t key, std::uint64_t purpose) {
    return mix64(keyed_hash(seed, key) ^ purpose);
}

/// Uniform in [0, 1) from a hash.
constexpr double unit_interval(std::uint64_t hash) {
    return static_cast<double>(hash >> 11) * 0x1.0p-53;
}

}  // namespace slim
