#include "slim/fit/variance_bins.h"

#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr int kPerOctave = 4;

}  // namespace

void VarianceBins::add(int bin, const Bin& more) {
    Bin& b = bins_[bin];
    b.n += more.n, b.variance += more.variance, b.flatness += more.flatness;
}

/// From the parts of the number, which scaling by a power of two leaves as they are.
int VarianceBins::bin_of(double variance) {
    if (!(variance > 0)) return kPerOctave * std::numeric_limits<double>::min_exponent * 2;
    int exponent;
    const double mantissa = std::frexp(variance, &exponent);  // [1/2, 1)
    return kPerOctave * exponent + static_cast<int>((mantissa - 0.5) * 2 * kPerOctave);
}

double VarianceBins::begin_of(int bin) {
    const int exponent = static_cast<int>(std::floor(static_cast<double>(bin) / kPerOctave));
    const int part = bin - kPerOctave * exponent;
    return std::ldexp(0.5 + static_cast<double>(part) / (2 * kPerOctave), exponent);
}

double VarianceBins::quantile(double share) const {
    std::uint64_t n = 0, seen = 0;
    for (const auto& [bin, b] : bins_) n += b.n;
    const double wanted = share * static_cast<double>(n);
    for (const auto& [bin, b] : bins_) {
        seen += b.n;
        if (static_cast<double>(seen) >= wanted) return begin_of(bin + 1);
    }
    return 0;
}

VarianceBins::Bin VarianceBins::mean_up_to(double most) const {
    Bin mean;
    for (const auto& [bin, b] : bins_)
        if (begin_of(bin) <= most)
            mean.n += b.n, mean.variance += b.variance, mean.flatness += b.flatness;
    if (mean.n == 0) return mean;
    mean.variance /= static_cast<double>(mean.n);
    mean.flatness /= static_cast<double>(mean.n);
    return mean;
}

}  // namespace slim
