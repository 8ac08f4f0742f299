#include "slim/slicing/axis_histogram.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// Bin numbers beyond this would not be exact in a double.
constexpr double kFarthestBin = 0x1p51;

std::int64_t floor_half(std::int64_t i) { return i >= 0 ? i / 2 : (i - 1) / 2; }

double first_width(double lo, double hi) {
    const double largest = std::max(std::abs(lo), std::abs(hi));
    const double wanted = std::max((hi - lo) / static_cast<double>(AxisHistogram::kBins / 2),
                                   largest / kFarthestBin);
    return wanted > 0 && std::isfinite(wanted)
               ? std::ldexp(1.0, std::clamp(std::ilogb(wanted), -1000, 1000))
               : 0x1p-1000;
}

}  // namespace

AxisHistogram::AxisHistogram(double lo, double hi)
    : width_(first_width(lo, hi)), counts_(static_cast<std::size_t>(kBins)) {
    while (std::abs(lo) / width_ > kFarthestBin || std::abs(hi) / width_ > kFarthestBin) width_ *= 2;
    first_ = bin_of(lo);
}

std::int64_t AxisHistogram::bin_of(double value) const {
    const double bin = std::floor(value / width_);
    // Far outside: only the side matters, make_room() will coarsen until it fits.
    return static_cast<std::int64_t>(std::clamp(bin, -2 * kFarthestBin, 2 * kFarthestBin));
}

void AxisHistogram::coarsen() {
    const std::int64_t first = floor_half(first_);
    std::vector<std::uint64_t> merged(counts_.size());
    for (std::int64_t k = 0; k < kBins; ++k)
        merged[static_cast<std::size_t>(floor_half(first_ + k) - first)] +=
            counts_[static_cast<std::size_t>(k)];
    counts_ = std::move(merged);
    first_ = first;
    width_ *= 2;
}

void AxisHistogram::shift(std::int64_t first) {
    std::vector<std::uint64_t> moved(counts_.size());
    for (std::int64_t k = 0; k < kBins; ++k) {
        const std::uint64_t count = counts_[static_cast<std::size_t>(k)];
        if (count > 0) moved[static_cast<std::size_t>(first_ + k - first)] = count;
    }
    counts_ = std::move(moved);
    first_ = first;
}

std::int64_t AxisHistogram::make_room(double value) {
    for (;;) {
        const std::int64_t bin = bin_of(value);
        const auto used = [](std::uint64_t count) { return count > 0; };
        const auto lowest = std::find_if(counts_.begin(), counts_.end(), used);
        if (lowest == counts_.end() && std::abs(value) / width_ <= kFarthestBin) {
            first_ = bin;
            return bin;
        }
        const auto highest = std::find_if(counts_.rbegin(), counts_.rend(), used);
        const std::int64_t lo = std::min(bin, first_ + (lowest - counts_.begin()));
        const std::int64_t hi = std::max(bin, first_ + (kBins - 1 - (highest - counts_.rbegin())));
        if (hi - lo < kBins && std::abs(value) / width_ <= kFarthestBin) {
            shift(lo);
            return bin;
        }
        coarsen();
    }
}

double AxisHistogram::edge(std::size_t k) const {
    return static_cast<double>(first_ + static_cast<std::int64_t>(k)) * width_;
}

}  // namespace slim
