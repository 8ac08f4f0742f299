#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Counts of a coordinate in at most kBins bins over a range that need not be known beforehand: when a
/// value falls outside, bins merge in pairs. Bins are [i w, (i + 1) w) with w a power of two, so
/// merging and cutting are exact, and the counts do not depend on the order of the values.
class AxisHistogram {
public:
    static constexpr std::int64_t kBins = 4096;

    /// Chooses the first bin width for about this range of finite values; it can only grow from here.
    AxisHistogram(double lo, double hi);

    /// value must be finite.
    void add(double value) {
        std::int64_t bin = bin_of(value);
        if (bin < first_ || bin >= first_ + kBins) bin = make_room(value);
        ++counts_[static_cast<std::size_t>(bin - first_)];
    }
    double bin_width() const { return width_; }
    /// Lower end of stored bin k; exact.
    double edge(std::size_t k) const;
    const std::vector<std::uint64_t>& counts() const { return counts_; }

private:
    std::int64_t bin_of(double value) const;
    std::int64_t make_room(double value);
    void coarsen();
    void shift(std::int64_t first);

    double width_;
    std::int64_t first_ = 0;  ///< number of the bin in counts_[0]
    std::vector<std::uint64_t> counts_;
};

}  // namespace slim
