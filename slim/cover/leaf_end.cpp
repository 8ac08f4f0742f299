#include "slim/cover/leaf_end.h"

#include "slim/cover/leaf_reach.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace slim {
namespace {

constexpr double kMostBeyond = 1.25;  // spacings that a leaf is drawn beyond its last points
constexpr double kWidth = 4;          // of a strip, in spacings: the last of its points is a fourth
                                      // of a spacing from its end in the mean
constexpr double kLeastWidth = 0.24;  // over rho
constexpr std::size_t kEnough = 100;  // points: of fewer the steps of rims are half a spacing
constexpr int kLeastShare = 62;       // hundredths of its radius
constexpr double kSlack = 0.005;      // over rho: the smaller ball's points end a little elsewhere
constexpr double kNone = -1;          // a strip without points

/// How far the covered points reach in a direction, strip by strip across it: a border bends.
struct Profile {
    double last, margin, spacing, width;
    std::vector<double> reach;  // of strips side by side, the middle one at the centre

    Profile(const CoveringSurfel& leaf, int k, double last_of_all, const LeafEnd& end)
        : last(last_of_all),
          margin(end.margin),
          spacing(end.spacing),
          width(std::max(kLeastWidth, kWidth * end.spacing)) {
        const int half = static_cast<int>(kHitTrim / width);
        reach.assign(static_cast<std::size_t>(2 * half + 1), kNone);
        const auto [u, v] = rim_direction(k);
        for (const Covered& p : leaf.covered) {
            const double x = static_cast<double>(p.u), y = static_cast<double>(p.v);
            const auto i = std::lround((y * u - x * v) / width) + half;
            if (i < 0 || i > 2 * half) continue;
            double& far = reach[static_cast<std::size_t>(i)];
            far = std::max(far, x * u + y * v);
        }
    }
    /// How much is drawn beyond the points at most, over rho, in a ball `share` times as large.
    double drawn_beyond(double share) const {
        const double step = std::max(1.0, std::ceil((last + margin + kSlack) / share / kRimStep));
        const double end = step <= kRimReaches ? share * kRimStep * step : kHitTrim;
        double most = 0;
        for (std::size_t i = 0; i < reach.size(); ++i) {
            const double across =
                width * (static_cast<double>(i) - static_cast<double>(reach.size() / 2));
            const double sq_half = share * share * kHitTrim * kHitTrim - across * across;
            if (reach[i] == kNone || sq_half <= 0) continue;
            most = std::max(most, std::min(end, std::sqrt(sq_half)) - reach[i]);
        }
        return most;
    }
};

/// Those of the two directions in which the points surely end, nearest first, as of rims.
std::vector<Profile> ends_of(const CoveringSurfel& leaf, PerDirection reach) {
    std::vector<Profile> out;
    for (int i = 0; i < 2; ++i) {
        const auto nearest = std::min_element(reach.begin(), reach.end());
        const int k = static_cast<int>(nearest - reach.begin());
        const double last = static_cast<double>(*nearest);
        const LeafEnd end = end_beyond(last, static_cast<double>(leaf.covered.size()));
        if (last < kHitTrim && end.is_sure) out.emplace_back(leaf, k, last, end);
        for (int d = -kEndsApart; d <= kEndsApart; ++d) reach[direction(k + d)] = 1;
    }
    return out;
}

}  // namespace

double share_at_end(const CoveringSurfel& leaf) {
    if (leaf.fitted.surfel.sharp || leaf.covered.size() < kEnough) return 1;
    const auto reach = reaches_of(leaf, kHitTrim);
    if (!reach) return 1;
    const std::vector<Profile> ends = ends_of(leaf, *reach);
    const auto is_near = [&](double share) {
        return std::all_of(ends.begin(), ends.end(), [&](const Profile& end) {
            return end.drawn_beyond(share) <= kMostBeyond * end.spacing;
        });
    };
    for (int hundredths = 100; hundredths > kLeastShare; --hundredths)
        if (is_near(hundredths / 100.0)) return hundredths / 100.0;
    return kGoldenRatio;
}

}  // namespace slim
