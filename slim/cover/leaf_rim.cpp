#include "slim/cover/leaf_rim.h"

#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slim {
namespace {

/// Of the spacing sqrt(pi / n) of n points in the unit disc: between two neighbouring leaves' last points there
/// may be a gap, which both must reach across. Of a half-filled disc it is too much by 1.4.
constexpr double kMargin = 1.2;
constexpr double kOfEdge = 0.1;   // over rho: so far covered points may lie beyond an edge
constexpr double kNoRim = 1;      // over rho: where the ball ends
constexpr int kTogether = 2;      // directions, 22 degrees: signs of one edge
constexpr int kApart = 5;         // directions, 56 degrees: closer lines are one edge
constexpr std::size_t kGroups = kRimDirections / FloatV::size();
using PerDirection = std::array<FloatV, kGroups>;

struct Directions {
    PerDirection u, v;
    Directions() {
        for (std::size_t g = 0; g < kGroups; ++g) {
            const auto component = [g](std::size_t axis) {
                return FloatV([&](auto lane) {
                    const auto k = static_cast<int>(g * FloatV::size() + lane);
                    return static_cast<float>(rim_direction(k)[axis]);
                });
            };
            u[g] = component(0), v[g] = component(1);
        }
    }
};

/// How far the covered points reach in each direction, over rho; at least 0, where the centre is.
[[gnu::flatten]] PerDirection reaches_of(const CoveringSurfel& leaf) {
    static const Directions directions;
    PerDirection reach;
    reach.fill(FloatV(0.0f));
    for (const Covered& c : leaf.covered)
        for (std::size_t g = 0; g < kGroups; ++g)
            reach[g] = stdx::max(reach[g], directions.u[g] * c.u + directions.v[g] * c.v);
    return reach;
}

double reach_in(const PerDirection& reach, std::size_t k) {
    return static_cast<double>(reach[k / FloatV::size()][k % FloatV::size()]);
}

/// How far the leaf may reach in each direction, over rho.
struct Bounds {
    std::array<double, kRimDirections> reach;

    int nearest() const {
        return static_cast<int>(std::min_element(reach.begin(), reach.end()) - reach.begin());
    }
    void leave_out(int k, int width) {
        for (int d = -width; d <= width; ++d) reach[direction(k + d)] = kNoRim;
    }
    static std::size_t direction(int k) {
        return static_cast<std::size_t>((k + kRimDirections) % kRimDirections);
    }
};

/// Sums of the signs of edges by direction; those that would cut off covered points say nothing.
struct EdgeVotes {
    std::array<int, kRimDirections> n{};
    std::array<double, kRimDirections> reach{};

    EdgeVotes(const std::vector<EdgeSign>& edges, const PerDirection& covered) {
        for (const EdgeSign& e : edges) {
            const double angle = std::atan2(e.v, e.u) / (2 * std::numbers::pi) * kRimDirections;
            const std::size_t k = Bounds::direction(static_cast<int>(std::lround(angle)));
            if (reach_in(covered, k) > static_cast<double>(e.reach) + kOfEdge) continue;
            ++n[k], reach[k] += static_cast<double>(e.reach);
        }
    }
    /// Mean reach of the signs about a direction that has the most of them; kNoRim elsewhere.
    double mean(int k) const {
        int count = 0;
        double sum = 0;
        for (int d = -kTogether; d <= kTogether; ++d) {
            const std::size_t i = Bounds::direction(k + d);
            if (n[i] > n[Bounds::direction(k)]) return kNoRim;
            count += n[i], sum += reach[i];
        }
        return count > 0 ? sum / count : kNoRim;
    }
};

Bounds bounds_of(const CoveringSurfel& leaf, const PerDirection& covered) {
    const double margin =
        kMargin * std::sqrt(std::numbers::pi / static_cast<double>(leaf.covered.size()));
    const EdgeVotes votes(leaf.edges, covered);
    Bounds out;
    for (int k = 0; k < kRimDirections; ++k) {
        const double last = reach_in(covered, Bounds::direction(k));
        out.reach[Bounds::direction(k)] = std::min(last + margin, std::max(last, votes.mean(k)));
    }
    return out;
}

}  // namespace

PackedRims rims_of(const CoveringSurfel& leaf) {
    if (leaf.fitted.surfel.sharp || leaf.covered.empty()) return {};
    Bounds bounds = bounds_of(leaf, reaches_of(leaf));
    const int first = bounds.nearest();
    const PackedRim rim = pack_rim(first, bounds.reach[Bounds::direction(first)]);
    if (rim == 0) return {};
    bounds.leave_out(first, kApart);
    const int second = bounds.nearest();
    return {rim, pack_rim(second, bounds.reach[Bounds::direction(second)])};
}

}  // namespace slim
