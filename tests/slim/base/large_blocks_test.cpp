#include "slim/base/large_blocks.h"

#include "slim/base/unfilled_vector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace slim::test {
namespace {

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

constexpr std::size_t kMiB = std::size_t{1} << 20;

/// Not inlined: a compiler may leave out what is freed at once.
[[gnu::noinline]] std::unique_ptr<char[]> block_of(std::size_t n) { return std::unique_ptr<char[]>(new char[n]); }
std::uintptr_t place_of(const std::unique_ptr<char[]>& block) { return reinterpret_cast<std::uintptr_t>(block.get()); }

TEST(LargeBlocks, ServeTheNextOneWholeOrInParts) {
    release_large_blocks();
    auto first = block_of(64 * kMiB);
    const std::uintptr_t begin = place_of(first);
    first.reset();
    EXPECT_GE(large_block_use().kept, 64 * kMiB);
    const auto a = block_of(20 * kMiB), b = block_of(30 * kMiB);
    EXPECT_EQ(place_of(a), begin);
    EXPECT_EQ(place_of(b), begin + 20 * kMiB);
    EXPECT_EQ(large_block_use().kept, 14 * kMiB);
    release_large_blocks();
    EXPECT_EQ(large_block_use().kept, 0u);
}

TEST(LargeBlocks, JoinNeighboursThatWereFreed) {
    release_large_blocks();
    block_of(64 * kMiB).reset();
    auto a = block_of(20 * kMiB), b = block_of(20 * kMiB), c = block_of(20 * kMiB);
    const std::uintptr_t begin = place_of(a);
    b.reset(), a.reset(), c.reset();
    EXPECT_EQ(place_of(block_of(60 * kMiB)), begin);
}

TEST(LargeBlocks, AreNoMoreThanFourFifthsOfWhatWasInUse) {
    release_large_blocks();
    std::vector<std::unique_ptr<char[]>> some;
    while (some.size() < 10 || large_block_use().in_use < large_block_use().most_in_use)
        some.push_back(block_of(10 * kMiB));
    const std::size_t most = large_block_use().most_in_use;
    for (std::size_t i = 0; i < some.size(); i += 2) some[i].reset();
    const auto larger = block_of(11 * kMiB);  // than any kept, unless neighbours were freed
    const LargeBlockUse use = large_block_use();
    EXPECT_GT(use.kept, 0u);
    EXPECT_LE(use.in_use + use.kept, most / 5 * 4);
    const auto largest = block_of(most);
    EXPECT_EQ(large_block_use().kept, 0u);
}

TEST(LargeBlocks, HaveTheAlignmentThatIsAskedFor) {
    struct alignas(64) Line {
        char bytes[64];
    };
    const std::vector<Line> lines(kMiB);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.data()) % 64, 0u);
    const UnfilledVector<Line> few(3);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(few.data()) % 64, 0u);
}

TEST(LargeBlocks, AreGivenAndFreedByAnyThread) {
    const std::size_t before = large_block_use().in_use;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([t] {
            for (std::size_t i = 1; i < 16; ++i) {
                std::vector<std::size_t> values(i * kMiB / 16, i);
                std::vector<std::size_t> copy = values;
                copy.back() = static_cast<std::size_t>(t);
                ASSERT_EQ(values.back(), i);
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(large_block_use().in_use, before);
}

#endif

}  // namespace
}  // namespace slim::test
