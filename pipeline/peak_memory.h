#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

namespace slim {

/// The largest resident memory of this process while the meter lives, in bytes, mapped pages
/// included. The outermost meter reads the kernel's high-water mark, which counts from the start of
/// the process. Meters within it (a build holds those of its stages) read it where it rises in
/// their life; where an earlier stage took more, the largest of a sample every few milliseconds.
/// The mark is never reset: it is what `/usr/bin/time -v` and a batch system see. Not for
/// concurrent use.
class PeakMeter {
public:
    PeakMeter();
    ~PeakMeter();
    PeakMeter(const PeakMeter&) = delete;
    PeakMeter& operator=(const PeakMeter&) = delete;

    std::uint64_t bytes() const;

private:
    void sample();

    bool outermost_;
    std::uint64_t mark_before_;
    mutable std::mutex mutex_;
    std::condition_variable ends_;
    bool ended_ = false;
    std::uint64_t largest_sample_ = 0;
    std::thread sampler_;
};

/// What becomes of freed small blocks from now on: with several slices they go back to the system at once, with one they
/// are kept: the system clears every page that it gives anew. Large ones: slim/base/large_blocks.h.
void keep_freed_memory(bool keep);

/// Gives small blocks that were freed and kept back to the system, those of other threads' heaps included: between
/// slices and stages. Cost: a few ms.
void return_freed_memory();

}  // namespace slim
