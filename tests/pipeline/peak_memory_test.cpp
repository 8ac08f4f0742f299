#include "pipeline/peak_memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

namespace slim::test {
namespace {

[[maybe_unused]] constexpr std::size_t kThreads = 8, kMiB = std::size_t{1} << 20;

TEST(PeakMemory, TheOuterMeterSeesWhatTheInnerOneSaw) {
    constexpr std::size_t kBytes = std::size_t{64} << 20;
    const PeakMeter outer;
    {
        const PeakMeter inner;
        const std::vector<char> block(kBytes, 1);
        EXPECT_EQ(block[kBytes / 2], 1);
        EXPECT_GE(inner.bytes(), kBytes);
    }
    const PeakMeter later;  // starts anew where the kernel allows it
    EXPECT_GE(outer.bytes(), kBytes);
    EXPECT_LE(later.bytes(), outer.bytes());
}

/// Pages taken anew by a slice that uses one block of so many bytes.
long new_pages_of_slice(FreedBetweenSlices& freed, std::size_t bytes) {
    const auto pages = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return usage.ru_minflt;
    };
    freed.begin_next();
    const long before = pages();
    const std::vector<char> block(bytes, 1);
    EXPECT_EQ(block[bytes / 2], 1);
    return pages() - before;
}

#ifndef __SANITIZE_ADDRESS__  // whose allocator keeps what it likes
TEST(PeakMemory, SlicesFindThePagesOfThoseBeforeWhereThereIsRoom) {
    constexpr std::size_t kBytes = std::size_t{64} << 20;  // more than glibc keeps by itself
    constexpr long kPages = kBytes / 4096;
    const PeakMeter outer;
    for (const bool is_roomy : {true, false}) {
        FreedBetweenSlices freed(is_roomy ? std::uint64_t{1} << 40 : kBytes, kBytes);
        new_pages_of_slice(freed, kBytes);
        new_pages_of_slice(freed, kBytes);
        const long third = new_pages_of_slice(freed, kBytes);
        if (is_roomy)
            EXPECT_LT(third, kPages / 10);
        else
            EXPECT_GT(third, kPages / 600);  // huge pages at the most
    }
    keep_freed_memory(false);
}

/// Addresses that this process has in use, as `ulimit -v` counts them.
std::size_t address_space() {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// Addresses that a block of memory in each of some threads takes, without the threads' stacks.
std::size_t taken_by_blocks_of_threads() {
    const std::size_t before = address_space();
    std::atomic<std::size_t> ready = 0;
    std::atomic<bool> done = false;
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < kThreads; ++i)
        threads.emplace_back([&] {
            const auto block = std::make_unique<char[]>(1000);
            ++ready;
            while (!done) std::this_thread::yield();
        });
    while (ready < kThreads) std::this_thread::yield();
    const std::size_t taken = address_space() - before, stacks = kThreads * 9 * kMiB;
    done = true;
    for (std::thread& thread : threads) thread.join();
    return taken > stacks ? taken - stacks : 0;
}

/// Ends the process with 0 if they take less than 64 MiB.
[[noreturn]] void end_by_addresses(bool limited) {
    const rlimit limit{4096 * kMiB, 4096 * kMiB};
    if (limited && setrlimit(RLIMIT_AS, &limit) != 0) std::_Exit(2);
    share_one_heap_under_a_limit();
    std::_Exit(taken_by_blocks_of_threads() < 64 * kMiB ? 0 : 1);
}

TEST(PeakMemoryDeathTest, ThreadsShareOneHeapUnderALimitOnAddresses) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(end_by_addresses(true), testing::ExitedWithCode(0), "");
    EXPECT_EXIT(end_by_addresses(false), testing::ExitedWithCode(1), "");  // each has its own
}
#endif

}  // namespace
}  // namespace slim::test
