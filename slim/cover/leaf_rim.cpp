#include "slim/cover/leaf_rim.h"

#include "slim/base/simd.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace slim {
namespace {

/// Of the spacing sqrt(pi / n) of n points in the unit disc: between two neighbouring leaves' last points there
/// may be a gap, which both must reach across. Of a half-filled disc it is too much by 1.4.
constexpr double kMargin = 1.2;
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

}  // namespace

PackedRim rim_of(const CoveringSurfel& leaf) {
    if (leaf.fitted.surfel.sharp || leaf.covered.empty()) return 0;
    const double margin =
        kMargin * std::sqrt(std::numbers::pi / static_cast<double>(leaf.covered.size()));
    const PerDirection reach = reaches_of(leaf);
    const auto reach_in = [&](int k) {
        const auto i = static_cast<std::size_t>(k);
        return static_cast<double>(reach[i / FloatV::size()][i % FloatV::size()]);
    };
    int least = 0;
    for (int k = 1; k < kRimDirections; ++k)
        if (reach_in(k) < reach_in(least)) least = k;
    return pack_rim(least, reach_in(least) + margin);
}

}  // namespace slim
