#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace slim {

inline constexpr int kMostThreads = 4096;

/// Number of threads to use: `wanted` > 0, else SLIM_THREADS, else SLURM_CPUS_PER_TASK, else what
/// TBB sees of this process (CONVENTIONS 2.2). Throws ConfigError on a variable that is no count up
/// to kMostThreads.
int resolve_threads(int wanted);

/// Bounds TBB to n threads while alive; one at a time, in main.
class ThreadLimit {
public:
    explicit ThreadLimit(int n_threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    void* control_;
};

/// Calls body(begin, end) over [0, n) in blocks of `grain` (the last shorter). The blocks are the
/// same for any number of threads, so a result kept per block is deterministic.
void parallel_blocks(std::size_t n, std::size_t grain,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

/// std::erase_if, in parallel; `unwanted` may be asked in any order.
template <class T, class Unwanted>
void parallel_erase_if(std::vector<T>& values, const Unwanted& unwanted) {
    constexpr std::size_t kGrain = 16384;
    const auto at = [&](std::size_t i) { return values.begin() + static_cast<std::ptrdiff_t>(i); };
    std::vector<std::size_t> kept((values.size() + kGrain - 1) / kGrain);
    parallel_blocks(values.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        const auto last = std::remove_if(at(begin), at(end), unwanted);
        kept[begin / kGrain] = static_cast<std::size_t>(last - at(begin));
    });
    std::size_t n = 0;
    for (std::size_t b = 0; b < kept.size(); ++b) {
        if (n < b * kGrain) std::move(at(b * kGrain), at(b * kGrain + kept[b]), at(n));
        n += kept[b];
    }
    values.resize(n);
}

/// Does two pieces of work, at the same time if there are threads.
/// throws what either throws, once both have ended
void run_both(const std::function<void()>& a, const std::function<void()>& b);

/// Work that another thread does, if there is one that waits, while this one goes on: one piece
/// after the other. Not for pieces that wait for this thread.
class WorkAside {
public:
    WorkAside();
    /// Waits for a piece that has begun; one that has not is left out.
    ~WorkAside();
    WorkAside(const WorkAside&) = delete;
    WorkAside& operator=(const WorkAside&) = delete;

    /// Begins a piece once the one before it has ended; throws what that one threw.
    void run(std::function<void()> piece);
    /// Until the last piece has ended; this thread does it if no other has begun. Throws what it
    /// threw.
    void wait();

private:
    struct Group;
    std::unique_ptr<Group> group_;
};

}  // namespace slim
