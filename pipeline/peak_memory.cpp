#include "pipeline/peak_memory.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include <sys/resource.h>

namespace slim {
namespace {

PeakMeter* innermost = nullptr;

/// VmHWM of /proc/self/status, which unlike ru_maxrss starts anew at exec and can be reset.
std::uint64_t high_water_mark() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:"))
            return 1024 * std::strtoull(line.c_str() + 6, nullptr, 10);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return 1024 * static_cast<std::uint64_t>(usage.ru_maxrss);
}

void reset_high_water_mark() { std::ofstream("/proc/self/clear_refs") << "5"; }

}  // namespace

PeakMeter::PeakMeter() : outer_(innermost) {
    const std::uint64_t mark = high_water_mark();
    for (PeakMeter* meter = outer_; meter; meter = meter->outer_)
        meter->before_ = std::max(meter->before_, mark);
    innermost = this;
    if (outer_) reset_high_water_mark();
}

PeakMeter::~PeakMeter() {
    const std::uint64_t peak = bytes();
    if (outer_) outer_->before_ = std::max(outer_->before_, peak);
    if (innermost == this) innermost = outer_;
}

std::uint64_t PeakMeter::bytes() const { return std::max(before_, high_water_mark()); }

}  // namespace slim
