#include "slim/cover/two_layers.h"

#include <cstddef>

namespace slim {
namespace {

constexpr std::size_t kLeastPoints = 24;
constexpr double kMostKurtosis = 1.5;

}  // namespace

bool lies_between_layers(const CoveringSurfel& leaf) {
    const std::size_t n = leaf.covered.size();
    if (leaf.fitted.surfel.sharp || n < kLeastPoints) return false;
    double mean = 0, second = 0, fourth = 0;
    for (const Covered& p : leaf.covered) mean += static_cast<double>(p.off);
    mean /= static_cast<double>(n);
    for (const Covered& p : leaf.covered) {
        const double off = static_cast<double>(p.off) - mean;
        second += off * off, fourth += off * off * off * off;
    }
    return fourth * static_cast<double>(n) < kMostKurtosis * second * second;
}

}  // namespace slim
