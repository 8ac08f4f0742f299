#pragma once

#include <cstdint>

namespace slim {

/// The largest resident memory of this process while the meter lives, in bytes. Meters may nest (a
/// build holds those of its stages): each start resets the kernel's high-water mark after telling it
/// to the meters alive. Where the mark cannot be reset, it is the process's peak: never too small.
/// Not for concurrent use.
class PeakMeter {
public:
    PeakMeter();
    ~PeakMeter();
    PeakMeter(const PeakMeter&) = delete;
    PeakMeter& operator=(const PeakMeter&) = delete;

    std::uint64_t bytes() const;

private:
    PeakMeter* outer_;
    std::uint64_t before_ = 0;  // highest mark seen in this meter's life up to the last reset
};

}  // namespace slim
