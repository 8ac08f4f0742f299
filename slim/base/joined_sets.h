#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace slim {

/// Sets of the numbers 0 to n - 1, joined two by two, each known by its least member, in whatever
/// order they were joined (Tarjan 1975).
class JoinedSets {
public:
    JoinedSets() = default;
    explicit JoinedSets(std::size_t n) : parent_(n) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    /// The least member of the set that i is in.
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// The same; several threads may ask at once.
    std::uint32_t find(std::uint32_t i) const {
        while (parent_[i] != i) i = parent_[i];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    /// The sets numbered without gaps, by their least members: of each i, and how many there are.
    std::pair<std::vector<std::uint32_t>, std::size_t> numbered() {
        std::vector<std::uint32_t> out(parent_.size());
        std::uint32_t n = 0;
        for (std::uint32_t i = 0; i < out.size(); ++i) out[i] = find(i) == i ? n++ : out[find(i)];
        return {std::move(out), n};
    }

private:
    std::vector<std::uint32_t> parent_;  // never above the number itself
};

}  // namespace slim
