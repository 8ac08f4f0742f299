#include "pipeline/peak_memory.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include <fcntl.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

namespace slim {
namespace {

constexpr std::chrono::milliseconds kBetweenSamples{10};

constexpr int kLarge = 1 << 20, kLargest = 32 << 20;  // the most that glibc takes

int n_alive = 0;

/// An entry of /proc/self/status such as "VmHWM", in bytes; 0 if there is none.
std::uint64_t status_entry(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with(key + ":"))
            return 1024 * std::strtoull(line.c_str() + key.size() + 1, nullptr, 10);
    return 0;
}

/// Memory held now, by /proc/self/statm, which costs a tenth of /proc/self/status. The file is
/// opened once: opening it took more than reading it.
class ResidentMemory {
public:
    ResidentMemory() : file_(open("/proc/self/statm", O_RDONLY | O_CLOEXEC)) {}
    ~ResidentMemory() {
        if (file_ >= 0) close(file_);
    }
    ResidentMemory(const ResidentMemory&) = delete;
    ResidentMemory& operator=(const ResidentMemory&) = delete;

    /// 0 if there is no such file
    std::uint64_t bytes() const {
        char text[128] = {};
        if (file_ < 0 || pread(file_, text, sizeof text - 1, 0) <= 0) return 0;
        char* second = text;
        std::strtoull(text, &second, 10);  // all that is mapped
        return std::strtoull(second, nullptr, 10) *
               static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    }

private:
    int file_;
};

/// Unlike ru_maxrss, VmHWM starts anew at exec.
std::uint64_t high_water_mark() {
    if (const std::uint64_t mark = status_entry("VmHWM"); mark > 0) return mark;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return 1024 * static_cast<std::uint64_t>(usage.ru_maxrss);
}

// Of the memory that may be taken: while the slices so far took no more, what they freed is kept.
// Larger ones may follow, and what lies between blocks is a tenth (pipeline/notes/0005, 0006).
constexpr double kRoomy = 0.85;
constexpr int kUsualMaps = 65536;  // blocks that glibc maps by themselves at a time, unless told

void set_kept(std::uint64_t largest_block, std::uint64_t at_the_end, int most_maps = kUsualMaps) {
    mallopt(M_MMAP_THRESHOLD, static_cast<int>(largest_block));  // set, it no longer adapts
    mallopt(M_TRIM_THRESHOLD, static_cast<int>(at_the_end));
    mallopt(M_MMAP_MAX, most_maps);
}

}  // namespace

void keep_freed_memory(bool keep) {
    set_kept(keep ? kLargest : kLarge, keep ? 1 << 30 : kLarge);
    if (!keep) malloc_trim(0);
}

void keep_freed_memory_of_balls(std::uint64_t bytes_in_use) {
    const std::uint64_t large = std::clamp<std::uint64_t>(bytes_in_use / 64, kLarge, kLargest);
    set_kept(large, 4 * large);
    malloc_trim(0);
}

void keep_all_freed_memory() { set_kept(kLargest, 1 << 30, 0); }

void return_freed_memory() { malloc_trim(0); }

void share_one_heap_under_a_limit() {
    rlimit addresses{};
    if (getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY)
        mallopt(M_ARENA_MAX, 1);
}

FreedBetweenSlices::FreedBetweenSlices(std::uint64_t most_bytes, std::uint64_t bytes_in_use)
    : most_bytes_(most_bytes), bytes_in_use_(bytes_in_use) {}

FreedBetweenSlices::~FreedBetweenSlices() {
    if (peak_) return_freed_memory();
}

void FreedBetweenSlices::begin_next() {
    const bool keeps =
        peak_ && static_cast<double>(peak_->bytes()) <= kRoomy * static_cast<double>(most_bytes_);
    if (keeps) return keep_all_freed_memory();
    keep_freed_memory_of_balls(bytes_in_use_);
    if (!peak_) peak_.emplace();
}

PeakMeter::PeakMeter() : outermost_(n_alive++ == 0), mark_before_(high_water_mark()) {
    if (!outermost_) sampler_ = std::thread([this] { sample(); });
}

PeakMeter::~PeakMeter() {
    --n_alive;
    if (outermost_) return;
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    ends_.notify_one();
    sampler_.join();
}

void PeakMeter::sample() {
    const ResidentMemory resident;
    std::unique_lock lock(mutex_);
    do {
        largest_sample_ = std::max(largest_sample_, resident.bytes());
    } while (!ends_.wait_for(lock, kBetweenSamples, [this] { return ended_; }));
}

std::uint64_t PeakMeter::bytes() const {
    const std::uint64_t mark = high_water_mark();
    if (outermost_ || mark > mark_before_) return mark;
    const std::lock_guard lock(mutex_);
    return std::max(largest_sample_, ResidentMemory().bytes());
}

}  // namespace slim
