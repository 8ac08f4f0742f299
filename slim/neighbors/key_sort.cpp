#include "slim/neighbors/key_sort.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr int kFirstBits = 8;               // of the first digit, whose parts then fit the cache
constexpr int kBits = 6;                    // of those that follow
constexpr std::size_t kFew = 24;            // items that are sorted by insertion
constexpr std::size_t kSmall = 4096;        // items that one thread deals with at once
constexpr std::size_t kLarge = 4 * kBlock;  // items of a part that all threads deal with

using Items = std::span<KeyedIndex>;
using Histogram = std::vector<std::uint32_t>;

bool less_by_key(const KeyedIndex& a, const KeyedIndex& b) { return a.key < b.key; }

/// The bits [shift, shift + bits) of a key.
struct Digit {
    int shift, bits;

    /// The highest below bit `top`.
    static Digit below(int top, int most_bits) {
        const int bits = std::min(top, most_bits);
        return {top - bits, bits};
    }
    std::size_t count() const { return std::size_t{1} << bits; }
    std::size_t of(const KeyedIndex& item) const { return (item.key >> shift) & (count() - 1); }
};

/// Bits in which any two keys differ.
std::uint64_t differing_bits(Items items) {
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

void insert_sorted(Items items) {
    for (std::size_t i = 1; i < items.size(); ++i) {
        const KeyedIndex item = items[i];
        std::size_t k = i;
        for (; k > 0 && item.key < items[k - 1].key; --k) items[k] = items[k - 1];
        items[k] = item;
    }
}

/// Sorts what one thread has in its cache, by the bits below `top`; where it ends up is `to` if
/// `is_wanted_there`, else where it was. Both are of one size.
void sort_in_cache(Items from, Items to, int top, bool is_wanted_there) {
    if (from.size() <= kFew || top == 0) {
        if (from.size() <= kFew) insert_sorted(from);
        if (is_wanted_there) std::copy(from.begin(), from.end(), to.begin());
        return;
    }
    const Digit digit = Digit::below(top, kBits);
    std::array<std::uint32_t, (1 << kBits) + 1> places{};
    for (const KeyedIndex& item : from) ++places[digit.of(item) + 1];
    std::partial_sum(places.begin(), places.end(), places.begin());
    for (const KeyedIndex& item : from) to[places[digit.of(item)]++] = item;
    // The place of each digit has moved on to where the next begins.
    std::size_t begin = 0;
    for (std::size_t d = 0; d < digit.count(); ++d) {
        const std::size_t n = places[d] - begin;
        if (n > 0)
            sort_in_cache(to.subspan(begin, n), from.subspan(begin, n), digit.shift,
                          !is_wanted_there);
        begin = places[d];
    }
}

/// Turns each block's counts of digits into the places its items go to;
/// returns where each digit begins.
std::vector<std::size_t> counts_to_places(std::vector<Histogram>& blocks, std::size_t n_digits) {
    std::vector<std::size_t> begins;
    std::uint32_t place = 0;
    for (std::size_t digit = 0; digit < n_digits; ++digit) {
        begins.push_back(place);
        for (Histogram& block : blocks) {
            const std::uint32_t count = block[digit];
            block[digit] = place;
            place += count;
        }
    }
    begins.push_back(place);
    return begins;
}

/// Moves all items to the parts of their digit, in their order. Returns where each part begins.
std::vector<std::size_t> part_by_digit(Items from, const Digit& digit, Items to) {
    std::vector<Histogram> blocks((from.size() + kBlock - 1) / kBlock);
    parallel_blocks(from.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        Histogram counts(digit.count());
        for (std::size_t i = begin; i < end; ++i) ++counts[digit.of(from[i])];
        blocks[begin / kBlock] = std::move(counts);
    });
    const std::vector<std::size_t> begins = counts_to_places(blocks, digit.count());
    parallel_blocks(from.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        Histogram& places = blocks[begin / kBlock];
        for (std::size_t i = begin; i < end; ++i) to[places[digit.of(from[i])]++] = from[i];
    });
    return begins;
}

/// Sorts items in place by the bits below `top`, with as much room in `other`.
void sort_below(Items items, Items other, int top) {
    if (top == 0) return;
    const Digit digit = Digit::below(top, kFirstBits);
    const std::vector<std::size_t> begins = part_by_digit(items, digit, other);
    const auto size_of = [&](std::size_t d) { return begins[d + 1] - begins[d]; };
    parallel_blocks(digit.count(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t d = begin; d < end; ++d)
            if (size_of(d) > 0 && size_of(d) <= kLarge)
                sort_in_cache(other.subspan(begins[d], size_of(d)),
                              items.subspan(begins[d], size_of(d)), digit.shift, true);
    });
    // A crowd in one corner of the space.
    for (std::size_t d = 0; d < digit.count(); ++d) {
        if (size_of(d) <= kLarge) continue;
        const Items part = items.subspan(begins[d], size_of(d));
        std::copy_n(&other[begins[d]], part.size(), part.begin());
        sort_below(part, other.subspan(begins[d], part.size()), digit.shift);
    }
}

}  // namespace

void sort_by_key(KeyedIndices& items) {
    if (std::is_sorted(items.begin(), items.end(), less_by_key)) return;
    if (items.size() <= kSmall) return std::stable_sort(items.begin(), items.end(), less_by_key);
    const int top = static_cast<int>(std::bit_width(differing_bits(items)));
    KeyedIndices other(items.size());
    sort_below(items, other, top);
}

}  // namespace slim
