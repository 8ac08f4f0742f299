#include "slim/neighbors/key_sort.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace slim {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr std::size_t kDigits = 256;
constexpr std::size_t kFew = 4096;  // items that a comparison sort deals with in the cache

using Histogram = std::array<std::uint32_t, kDigits>;

bool less_by_key(const KeyedIndex& a, const KeyedIndex& b) { return a.key < b.key; }

std::size_t digit_of(const KeyedIndex& item, int shift) { return (item.key >> shift) & 0xff; }

/// Bits in which any two keys differ.
std::uint64_t differing_bits(const KeyedIndices& items) {
    std::vector<std::uint64_t> partial((items.size() + kBlock - 1) / kBlock);
    parallel_blocks(items.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        std::uint64_t bits = 0;
        for (std::size_t i = begin; i < end; ++i) bits |= items[i].key ^ items[0].key;
        partial[begin / kBlock] = bits;
    });
    std::uint64_t bits = 0;
    for (const std::uint64_t b : partial) bits |= b;
    return bits;
}

/// Turns each block's counts of digits into the places its items go to.
void counts_to_places(std::vector<Histogram>& blocks) {
    std::uint32_t place = 0;
    for (std::size_t digit = 0; digit < kDigits; ++digit)
        for (Histogram& block : blocks) {
            const std::uint32_t count = block[digit];
            block[digit] = place;
            place += count;
        }
}

void sort_by_digit(const KeyedIndices& from, int shift, KeyedIndices& to) {
    std::vector<Histogram> blocks((from.size() + kBlock - 1) / kBlock, Histogram{});
    parallel_blocks(from.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        Histogram& counts = blocks[begin / kBlock];
        for (std::size_t i = begin; i < end; ++i) ++counts[digit_of(from[i], shift)];
    });
    counts_to_places(blocks);
    parallel_blocks(from.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        Histogram places = blocks[begin / kBlock];
        for (std::size_t i = begin; i < end; ++i) to[places[digit_of(from[i], shift)]++] = from[i];
    });
}

}  // namespace

void sort_by_key(KeyedIndices& items) {
    if (std::is_sorted(items.begin(), items.end(), less_by_key)) return;
    if (items.size() <= kFew) return std::stable_sort(items.begin(), items.end(), less_by_key);
    const std::uint64_t bits = differing_bits(items);
    KeyedIndices other(items.size());
    for (int shift = 0; shift < 64; shift += 8) {
        if ((bits >> shift & 0xff) == 0) continue;
        sort_by_digit(items, shift, other);
        items.swap(other);
    }
}

}  // namespace slim
