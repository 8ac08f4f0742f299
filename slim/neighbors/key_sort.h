#pragma once

#include "slim/base/unfilled_vector.h"

#include <cstdint>

namespace slim {

/// A thing's place in an order, and its index.
struct KeyedIndex {
    std::uint64_t key;
    std::uint32_t index;

    friend bool operator==(const KeyedIndex&, const KeyedIndex&) = default;
};

using KeyedIndices = UnfilledVector<KeyedIndex>;

/// Sorts by key; equal keys keep their order. The highest eight bits in which keys differ part the
/// items, then each part is sorted in a thread's cache; keys in order already cost one look.
/// Parallel; threads do not change the result.
/// Cost: a second array of the same size; 40 ns an item and core (keys of 63 bits).
void sort_by_key(KeyedIndices& items);

}  // namespace slim
