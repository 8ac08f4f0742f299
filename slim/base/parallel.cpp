#include "slim/base/parallel.h"

#include "slim/base/error.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

namespace slim {
namespace {

/// The count in an environment variable, 0 if it is not set.
int threads_from(const char* variable) {
    const char* text = std::getenv(variable);
    if (!text || !*text) return 0;
    int n = 0;
    const char* end = text + std::strlen(text);
    const auto result = std::from_chars(text, end, n);
    if (result.ec != std::errc() || result.ptr != end || n < 1 || n > kMostThreads)
        throw ConfigError(std::string(variable) + "=" + text +
                          ": expected a count of threads from 1 to " +
                          std::to_string(kMostThreads));
    return n;
}

}  // namespace

int resolve_threads(int wanted) {
    if (wanted > 0) return wanted;
    if (const int n = threads_from("SLIM_THREADS")) return n;
    if (const int n = threads_from("SLURM_CPUS_PER_TASK")) return n;
    return std::max(1, oneapi::tbb::info::default_concurrency());
}

ThreadLimit::ThreadLimit(int n_threads)
    : control_(new tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                       static_cast<std::size_t>(n_threads))) {}

ThreadLimit::~ThreadLimit() { delete static_cast<tbb::global_control*>(control_); }

void parallel_blocks(std::size_t n, std::size_t grain,
                     const std::function<void(std::size_t, std::size_t)>& body) {
    const std::size_t n_blocks = (n + grain - 1) / grain;
    tbb::parallel_for(std::size_t{0}, n_blocks, [&](std::size_t block) {
        const std::size_t begin = block * grain;
        body(begin, std::min(n, begin + grain));
    });
}

void run_both(const std::function<void()>& a, const std::function<void()>& b) {
    tbb::parallel_invoke(a, b);
}

struct WorkAside::Group {
    tbb::task_group tasks;
};

WorkAside::WorkAside() : group_(std::make_unique<Group>()) {}

WorkAside::~WorkAside() {
    group_->tasks.cancel();
    try {
        group_->tasks.wait();
    } catch (...) {  // nobody waits for what it did
    }
}

void WorkAside::run(std::function<void()> piece) {
    wait();
    group_->tasks.run(std::move(piece));
}

void WorkAside::wait() { group_->tasks.wait(); }

}  // namespace slim
