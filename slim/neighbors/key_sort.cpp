#include "slim/neighbors/key_sort.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <limits>
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

template <class Item>
using Items = std::span<Item>;
using Histogram = std::vector<std::uint32_t>;

std::uint64_t key_of(const KeyedIndex& item) { return item.key; }
std::uint64_t key_of(std::uint64_t number) { return number; }

struct LessByKey {
    template <class Item>
    bool operator()(const Item& a, const Item& b) const {
        return key_of(a) < key_of(b);
    }
};

/// The bits [shift, shift + bits) of a key.
struct Digit {
    int shift, bits;

    /// The highest below bit `top`.
    static Digit below(int top, int most_bits) {
        const int bits = std::min(top, most_bits);
        return {top - bits, bits};
    }
    std::size_t count() const { return std::size_t{1} << bits; }
    template <class Item>
    std::size_t of(const Item& item) const {
        return (key_of(item) >> shift) & (count() - 1);
    }
};

/// Bits in which any two keys differ.
template <class Item>
std::uint64_t differing_bits(Items<Item> items) {
    std::vector<std::uint64_t> partial((items.size() + kBlock - 1) / kBlock);
    parallel_blocks(items.size(), kBlock, [&](std::size_t begin, std::size_t end) {
        std::uint64_t bits = 0;
        for (std::size_t i = begin; i < end; ++i) bits |= key_of(items[i]) ^ key_of(items[0]);
        partial[begin / kBlock] = bits;
    });
    std::uint64_t bits = 0;
    for (const std::uint64_t b : partial) bits |= b;
    return bits;
}

template <class Item>
void insert_sorted(Items<Item> items) {
    for (std::size_t i = 1; i < items.size(); ++i) {
        const Item item = items[i];
        std::size_t k = i;
        for (; k > 0 && key_of(item) < key_of(items[k - 1]); --k) items[k] = items[k - 1];
        items[k] = item;
    }
}

/// Sorts what one thread has in its cache, by the bits below `top`; where it ends up is `to` if
/// `is_wanted_there`, else where it was. Both are of one size.
template <class Item>
void sort_in_cache(Items<Item> from, Items<Item> to, int top, bool is_wanted_there) {
    if (from.size() <= kFew || top == 0) {
        if (from.size() <= kFew) insert_sorted(from);
        if (is_wanted_there) std::copy(from.begin(), from.end(), to.begin());
        return;
    }
    const Digit digit = Digit::below(top, kBits);
    std::array<std::uint32_t, (1 << kBits) + 1> places{};
    for (const Item& item : from) ++places[digit.of(item) + 1];
    std::partial_sum(places.begin(), places.end(), places.begin());
    for (const Item& item : from) to[places[digit.of(item)]++] = item;
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
template <class Item>
std::vector<std::size_t> part_by_digit(Items<Item> from, const Digit& digit, Items<Item> to) {
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
template <class Item>
void sort_below(Items<Item> items, Items<Item> other, int top) {
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
        const Items<Item> part = items.subspan(begins[d], size_of(d));
        std::copy_n(&other[begins[d]], part.size(), part.begin());
        sort_below(part, other.subspan(begins[d], part.size()), digit.shift);
    }
}

template <class Item>
void sort_all(UnfilledVector<Item>& items) {
    if (std::is_sorted(items.begin(), items.end(), LessByKey{})) return;
    if (items.size() <= kSmall) return std::stable_sort(items.begin(), items.end(), LessByKey{});
    const int top = static_cast<int>(std::bit_width(differing_bits<Item>(items)));
    UnfilledVector<Item> other(items.size());
    sort_below<Item>(items, other, top);
}

constexpr std::size_t kRowGrain = 16384;  // items a task
constexpr std::size_t kManyAlike = 4;     // one in so many items
constexpr std::size_t kLongestRow = 65536;  // that one thread may order

/// Calls body(first, end) for the rows of two or more of n items in which is_as_before(i) holds of
/// all but the first.
template <class IsAsBefore, class Body>
void for_rows(std::size_t n, const IsAsBefore& is_as_before, const Body& body) {
    parallel_blocks(n, kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && i + 1 < n; ++i) {
            if (!is_as_before(i + 1) || (i > 0 && is_as_before(i))) continue;
            std::size_t row_end = i + 2;
            while (row_end < n && is_as_before(row_end)) ++row_end;
            body(i, row_end);
        }
    });
}

/// The same where too many keys are alike in their highest bits.
std::vector<std::uint32_t> order_by_whole_key(
    const UnfilledVector<std::uint64_t>& keys,
    const std::function<void(std::span<std::uint32_t>)>& order_equal) {
    KeyedIndices items(keys.size());
    parallel_blocks(items.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            items[i] = {keys[i], static_cast<std::uint32_t>(i)};
    });
    sort_by_key(items);
    std::vector<std::uint32_t> order(items.size());
    parallel_blocks(items.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) order[i] = items[i].index;
    });
    if (order_equal)
        for_rows(
            items.size(), [&](std::size_t i) { return items[i].key == items[i - 1].key; },
            [&](std::size_t first, std::size_t end) {
                order_equal(std::span(order).subspan(first, end - first));
            });
    return order;
}

/// Orders a row of indices whose keys are alike in their highest bits.
void order_row(const UnfilledVector<std::uint64_t>& keys, std::span<std::uint32_t> row,
               const std::function<void(std::span<std::uint32_t>)>& order_equal) {
    std::sort(row.begin(), row.end(), [&](std::uint32_t a, std::uint32_t b) {
        return keys[a] != keys[b] ? keys[a] < keys[b] : a < b;
    });
    for (std::size_t begin = 0; order_equal && begin < row.size();) {
        std::size_t end = begin + 1;
        while (end < row.size() && keys[row[end]] == keys[row[begin]]) ++end;
        if (end - begin > 1) order_equal(row.subspan(begin, end - begin));
        begin = end;
    }
}

}  // namespace

void sort_by_key(KeyedIndices& items) { sort_all(items); }

void sort_numbers(UnfilledVector<std::uint64_t>& numbers) { sort_all(numbers); }

std::vector<std::uint32_t> order_by_key(
    const UnfilledVector<std::uint64_t>& keys,
    const std::function<void(std::span<std::uint32_t>)>& order_equal) {
    const std::size_t n = keys.size();
    SLIM_CHECK(n, <, std::size_t{std::numeric_limits<std::uint32_t>::max()});
    if (n == 0) return {};
    const int index_bits = static_cast<int>(std::bit_width(n - 1));
    const int top = static_cast<int>(std::bit_width(differing_bits<const std::uint64_t>(keys)));
    const int left_out = std::max(0, top + index_bits - 64);
    const std::uint64_t in_use = top == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << top) - 1;
    UnfilledVector<std::uint64_t> items(n);
    parallel_blocks(n, kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            items[i] = (keys[i] & in_use) >> left_out << index_bits | i;
    });
    sort_numbers(items);
    const auto is_as_before = [&](std::size_t i) {
        return (items[i] ^ items[i - 1]) >> index_bits == 0;
    };
    std::atomic<std::size_t> n_alike = 0;
    std::atomic<bool> is_long = false;
    for_rows(n, is_as_before, [&](std::size_t first, std::size_t end) {
        n_alike += end - first;
        if (end - first > kLongestRow) is_long = true;
    });
    if (left_out > 0 && (is_long || n_alike > n / kManyAlike))
        return order_by_whole_key(keys, order_equal);
    std::vector<std::uint32_t> order(n);
    const std::uint64_t index = (std::uint64_t{1} << index_bits) - 1;
    parallel_blocks(n, kRowGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            order[i] = static_cast<std::uint32_t>(items[i] & index);
    });
    if (n_alike > 0 && (left_out > 0 || order_equal))
        for_rows(n, is_as_before, [&](std::size_t first, std::size_t end) {
            const std::span<std::uint32_t> row = std::span(order).subspan(first, end - first);
            if (left_out > 0) return order_row(keys, row, order_equal);
            order_equal(row);
        });
    return order;
}

}  // namespace slim
