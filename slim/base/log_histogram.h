#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Counts of values >= 0 in bins of equal ratio, for percentiles of any number of values in
/// constant memory (64 KiB): exact counts, so that the order of values and of threads does not
/// matter.
class LogHistogram {
public:
    /// Bins an octave: a percentile is good to 0.3 %.
    static constexpr int kPerOctave = 128;
    /// 2^-128 and less count as 0, 2^128 and more as that.
    static constexpr int kOctaves = 128;

    void add(double value) {
        if (counts_.empty()) counts_.resize(kBins);
        ++counts_[bin(value)];
        ++n_;
        if (value > largest_) largest_ = value;
    }
    void add(const LogHistogram& other) {
        if (other.counts_.empty()) return;
        if (counts_.empty()) counts_.resize(kBins);
        for (std::size_t i = 0; i < kBins; ++i) counts_[i] += other.counts_[i];
        n_ += other.n_;
        largest_ = std::max(largest_, other.largest_);
    }
    std::uint64_t size() const { return n_; }

    /// The value that a share in (0, 1] of all values does not exceed, none above the largest; 0
    /// without values.
    double quantile(double share) const {
        const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(n_)));
        std::uint64_t seen = 0;
        for (std::size_t i = 0; i < counts_.size(); ++i) {
            seen += counts_[i];
            if (seen >= wanted && seen > 0) return std::min(middle(i), largest_);
        }
        return 0;
    }

private:
    static constexpr std::size_t kBins = 2 * kOctaves * kPerOctave + 1;

    static std::size_t bin(double value) {
        if (!(value > 0)) return 0;
        const double place = (std::log2(value) + kOctaves) * kPerOctave;
        return 1 + static_cast<std::size_t>(
                       std::clamp(place, 0.0, static_cast<double>(kBins - 2)));
    }
    static double middle(std::size_t i) {
        return i == 0 ? 0
                      : std::exp2((static_cast<double>(i - 1) + 0.5) / kPerOctave - kOctaves);
    }

    std::vector<std::uint64_t> counts_;
    std::uint64_t n_ = 0;
    double largest_ = 0;
};

}  // namespace slim
