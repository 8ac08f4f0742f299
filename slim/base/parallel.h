#pragma once

#include <cstddef>
#include <functional>

namespace slim {

/// Number of threads to use: `wanted` > 0, else SLIM_THREADS, else SLURM_CPUS_PER_TASK, else what
/// TBB sees of this process (CONVENTIONS 2.2). Throws ConfigError on a variable that is no count.
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

/// Calls body(begin, end) over [0, n) in blocks of `grain` (the last shorter). The blocks are the same
/// for any number of threads, so a result kept per block is deterministic.
void parallel_blocks(std::size_t n, std::size_t grain,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Does two pieces of work, at the same time if there are threads.
/// throws what either throws, once both have ended
void run_both(const std::function<void()>& a, const std::function<void()>& b);

}  // namespace slim
