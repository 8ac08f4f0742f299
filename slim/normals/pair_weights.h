#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim {

/// Weights of pairs of different numbers, at most `most` at a time: open addresses in one array, as
/// looking them up is what the joining of groups takes its time for (notes/0002). Weights are
/// finite. 32 to 64 bytes a pair.
class PairWeights {
public:
    static constexpr std::size_t kNone = ~std::size_t{0};

    explicit PairWeights(std::size_t most)
        : slots_(std::bit_ceil(std::max<std::size_t>(16, 2 * most))), mask_(slots_.size() - 1) {}

    /// Where the weight of a and b is, or kNone; until the next erase.
    std::size_t find(std::uint32_t a, std::uint32_t b) const {
        const std::uint64_t key = key_of(a, b);
        for (std::size_t at = home(key); slots_[at].key != kEmpty; at = (at + 1) & mask_)
            if (slots_[at].key == key) return at;
        return kNone;
    }
    double weight(std::size_t at) const { return slots_[at].weight; }

    /// Adds to the weight of a and b; returns where it is and whether there was none.
    std::pair<std::size_t, bool> add(std::uint32_t a, std::uint32_t b, double weight) {
        const std::uint64_t key = key_of(a, b);
        std::size_t at = home(key);
        for (; slots_[at].key != kEmpty; at = (at + 1) & mask_)
            if (slots_[at].key == key) {
                slots_[at].weight += weight;
                return {at, false};
            }
        slots_[at] = {key, weight};
        return {at, true};
    }

    /// Closes the gap, so that what was put behind the erased one is still found.
    void erase(std::size_t gap) {
        for (std::size_t at = (gap + 1) & mask_; slots_[at].key != kEmpty; at = (at + 1) & mask_) {
            const std::size_t from_home = (at - home(slots_[at].key)) & mask_;
            if (from_home < ((at - gap) & mask_)) continue;
            slots_[gap] = slots_[at];
            gap = at;
        }
        slots_[gap].key = kEmpty;
    }

    /// Calls visit(a, b, weight) for each, in an order that depends on what was added alone; a < b.
    template <class Visit>
    void for_each(const Visit& visit) const {
        for (const Slot& s : slots_)
            if (s.key != kEmpty)
                visit(static_cast<std::uint32_t>(s.key >> 32), static_cast<std::uint32_t>(s.key),
                      s.weight);
    }

private:
    static constexpr std::uint64_t kEmpty = 0;  // of no pair: its numbers differ
    struct Slot {
        std::uint64_t key = kEmpty;
        double weight = 0;
    };

    static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
        return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
    }
    std::size_t home(std::uint64_t key) const {
        return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15u) >> 20) & mask_;
    }

    std::vector<Slot> slots_;
    std::size_t mask_;
};

}  // namespace slim
