#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
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

/// What becomes of freed blocks from now on. With several slices large ones go back to the system
/// at once: else the allocator keeps those of one slice in a heap that has no room for the next
/// one's, half as much memory again. With one slice they are kept: the system clears every page
/// that it gives anew, a tenth of the processor time of a build (happy_stand_raw: 1.93 to 1.79 s at
/// 170 to 190 MiB).
void keep_freed_memory(bool keep);

/// The same for a job in slices that hold so many bytes at a time: blocks of up to a 64th of them,
/// the lists of balls, are kept, up to a 16th at the end of each thread's heap. A fit of 3.6
/// million points took 1.6 GB of new pages, half of them for such lists.
void keep_freed_memory_of_balls(std::uint64_t bytes_in_use);

/// The same for slices of which the largest leaves room in --memory for what lies between blocks:
/// nothing goes back, whatever its size, so that all slices but the first find their pages there
/// (pipeline/notes/0005).
void keep_all_freed_memory();

/// Gives what was freed and kept back to the system, small blocks and those of other threads' heaps
/// included: between slices and stages. Cost: a few ms.
void return_freed_memory();

/// Under a limit on addresses (`ulimit -v`) threads share one heap: one of each thread's own
/// reserves 64 MiB of addresses, used or not, and 268 MB of a limit of 1.1 GiB were such. Call it
/// before any other thread begins.
void share_one_heap_under_a_limit();

/// What becomes of freed memory in a job's slices, one after the other: it is kept for the next as
/// soon as those before have shown that there is room.
class FreedBetweenSlices {
public:
    /// most_bytes: that the process may take (--memory); bytes_in_use: by a usual slice
    FreedBetweenSlices(std::uint64_t most_bytes, std::uint64_t bytes_in_use);
    /// Gives what was kept back.
    ~FreedBetweenSlices();
    FreedBetweenSlices(const FreedBetweenSlices&) = delete;
    FreedBetweenSlices& operator=(const FreedBetweenSlices&) = delete;
    /// Call before each slice.
    void begin_next();

private:
    std::uint64_t most_bytes_, bytes_in_use_;
    std::optional<PeakMeter> peak_;  // of the slices so far
};

}  // namespace slim
