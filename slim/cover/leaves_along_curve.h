#pragma once

#include "slim/base/bbox.h"
#include "slim/neighbors/morton.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim {

/// Some leaves in the order of a curve: those that follow each other lie together, and so do the
/// points of their balls. surfel_of(leaf): its surfel. Cost: O(n log n).
template <class Leaf, class SurfelOf>
std::vector<Leaf*> leaves_along_curve(const std::vector<Leaf*>& leaves, const SurfelOf& surfel_of) {
    Bbox box;
    for (const Leaf* leaf : leaves) box.extend(surfel_of(*leaf).center);
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::size_t>> keys;
    keys.reserve(leaves.size());
    for (std::size_t i = 0; i < leaves.size(); ++i)
        keys.emplace_back(curve.key(surfel_of(*leaves[i]).center), i);
    std::sort(keys.begin(), keys.end());
    std::vector<Leaf*> out;
    out.reserve(leaves.size());
    for (const auto& [key, i] : keys) out.push_back(leaves[i]);
    return out;
}

}  // namespace slim
