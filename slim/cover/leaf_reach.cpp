#include "slim/cover/leaf_reach.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

/// Of the spacing sqrt(pi / n) of n points in the unit disc: between two neighbouring leaves' last
/// points there may be a gap, which both must reach across. Of a half-filled disc it is too much
/// by 1.4.
constexpr double kMargin = 1.2;
/// Where n points at random would all lie this side of the last one once in e^7 = 1,100 times only,
/// the surface has ended: half of a spacing is what a point stands for.
constexpr double kSurelyEnded = 7;
constexpr double kMarginOfBorder = 0.5;

struct Directions {
    PerDirection u, v;
    Directions() {
        for (int k = 0; k < kRimDirections; ++k) {
            const auto [x, y] = rim_direction(k);
            u[static_cast<std::size_t>(k)] = static_cast<float>(x);
            v[static_cast<std::size_t>(k)] = static_cast<float>(y);
        }
    }
};

/// Part of the unit disc beyond a chord at that distance from its centre.
double part_beyond(double reach) {
    const double x = std::min(reach, 1.0);
    return (std::acos(x) - x * std::sqrt(1 - x * x)) / std::numbers::pi;
}

}  // namespace

std::optional<PerDirection> reaches_of(const CoveringSurfel& leaf, double longest) {
    static const Directions directions;
    constexpr std::size_t kAtOnce = 24, kRounds = 16;
    PerDirection reach{};
    // Points that lie side by side reach one way: those far apart are asked first.
    for (std::size_t round = 0; round < kRounds; ++round)
        for (std::size_t i = round; i < leaf.covered.size();) {
            const std::size_t end = std::min(i + kAtOnce * kRounds, leaf.covered.size());
            for (; i < end; i += kRounds) {
                const float u = leaf.covered[i].u, v = leaf.covered[i].v;
                for (std::size_t k = 0; k < reach.size(); ++k)
                    reach[k] = std::max(reach[k], directions.u[k] * u + directions.v[k] * v);
            }
            if (*std::min_element(reach.begin(), reach.end()) > static_cast<float>(longest))
                return {};
        }
    return reach;
}

LeafEnd end_beyond(double last, double n) {
    const double beyond = part_beyond(last);
    const double spacing = std::sqrt(std::numbers::pi * (1 - beyond) / n);
    if (-n * std::log1p(-beyond) < kSurelyEnded)
        return {spacing, kMargin * std::sqrt(std::numbers::pi / n), false};
    return {spacing, kMarginOfBorder * spacing, true};
}

}  // namespace slim
