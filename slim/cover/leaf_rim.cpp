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
constexpr float kMargin = 1.2f;
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

/// How far the covered points reach in each direction, over rho.
struct Reaches {
    PerDirection last;   ///< the farthest; at least 0, where the centre is
    PerDirection third;  ///< the third of them from there: far behind where points thin out towards the rim
};

Reaches reaches_of(const CoveringSurfel& leaf, std::span<const Vec3d> position) {
    static const Directions directions;
    const Surfel& s = leaf.fitted.surfel;
    Reaches out;
    PerDirection second;
    for (PerDirection* reach : {&out.last, &second, &out.third}) reach->fill(FloatV(0.0f));
    for (const Covered& c : leaf.covered) {
        const Vec3d x = (position[c.point] - s.center) / s.support_radius;
        const auto u = static_cast<float>(dot(s.frame.u_axis, x));
        const auto v = static_cast<float>(dot(s.frame.v_axis, x));
        for (std::size_t g = 0; g < kGroups; ++g) {
            const FloatV at = directions.u[g] * u + directions.v[g] * v;
            out.third[g] = stdx::max(out.third[g], stdx::min(second[g], at));
            second[g] = stdx::max(second[g], stdx::min(out.last[g], at));
            out.last[g] = stdx::max(out.last[g], at);
        }
    }
    return out;
}

}  // namespace

PackedRim rim_of(const CoveringSurfel& leaf, std::span<const Vec3d> position) {
    if (leaf.fitted.surfel.sharp || leaf.covered.empty()) return 0;
    const float spacing = std::sqrt(std::numbers::pi_v<float> / static_cast<float>(leaf.covered.size()));
    const Reaches reaches = reaches_of(leaf, position);
    const auto rim_in = [&](int k) {
        const std::size_t g = static_cast<std::size_t>(k) / FloatV::size(),
                          lane = static_cast<std::size_t>(k) % FloatV::size();
        const float last = reaches.last[g][lane], thinning = last - reaches.third[g][lane];
        return last + kMargin * spacing + thinning;
    };
    int least = 0;
    for (int k = 1; k < kRimDirections; ++k)
        if (rim_in(k) < rim_in(least)) least = k;
    return pack_rim(least, static_cast<double>(rim_in(least)));
}

}  // namespace slim
