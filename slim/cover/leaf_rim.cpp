#include "slim/cover/leaf_rim.h"

#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace slim {
namespace {

/// Of the spacing sqrt(pi / n) of n points in the unit disc: between two neighbouring leaves' last points there
/// may be a gap, which both must reach across. Of a half-filled disc it is too much by 1.4.
constexpr double kMargin = 1.2;
/// The same where points that the leaf does not explain show that its surface ends before them: beyond half way
/// to the first of them, to be met by the leaf that explains it.
constexpr double kMarginAtEdge = 0.3;
constexpr float kLeastBeyond = 3;  // so many of them; one may be a stray

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

/// Calls visit(u, v) with the place of a point in a leaf's tangent plane, over rho.
template <class Visit>
void with_place(const Surfel& s, std::span<const Vec3d> position, std::uint32_t point, Visit&& visit) {
    const Vec3d x = (position[point] - s.center) / s.support_radius;
    visit(static_cast<float>(dot(s.frame.u_axis, x)), static_cast<float>(dot(s.frame.v_axis, x)));
}

/// What lies in each direction, over rho.
struct Reaches {
    PerDirection covered;  ///< how far the covered points reach; at least 0, where the centre is
    PerDirection first;    ///< the nearest beyond of those that are not explained
    PerDirection n_beyond; ///< how many of these there are
};

Reaches reaches_of(const CoveringSurfel& leaf, std::span<const Vec3d> position) {
    static const Directions directions;
    const Surfel& s = leaf.fitted.surfel;
    Reaches out;
    out.covered.fill(FloatV(0.0f)), out.first.fill(FloatV(2.0f)), out.n_beyond.fill(FloatV(0.0f));
    for (const Covered& c : leaf.covered)
        with_place(s, position, c.point, [&](float u, float v) {
            for (std::size_t g = 0; g < kGroups; ++g)
                out.covered[g] = stdx::max(out.covered[g], directions.u[g] * u + directions.v[g] * v);
        });
    for (const std::uint32_t p : leaf.unexplained)
        with_place(s, position, p, [&](float u, float v) {
            for (std::size_t g = 0; g < kGroups; ++g) {
                const FloatV at = directions.u[g] * u + directions.v[g] * v;
                const auto beyond = at > out.covered[g];
                out.first[g] = select<FloatV>(beyond, stdx::min(out.first[g], at), out.first[g]);
                out.n_beyond[g] += select<FloatV>(beyond, FloatV(1.0f), FloatV(0.0f));
            }
        });
    return out;
}

/// How far a rim must reach in each direction.
PerDirection rims_of(const Reaches& reaches, float spacing) {
    PerDirection rim;
    for (std::size_t g = 0; g < kGroups; ++g) {
        const FloatV half = 0.5f * (reaches.first[g] - reaches.covered[g]);
        const FloatV margin = static_cast<float>(kMargin) * spacing;
        const FloatV at_edge = stdx::min(margin, half + static_cast<float>(kMarginAtEdge) * spacing);
        rim[g] = reaches.covered[g] + select<FloatV>(reaches.n_beyond[g] >= kLeastBeyond, at_edge, margin);
    }
    return rim;
}

}  // namespace

PackedRim rim_of(const CoveringSurfel& leaf, std::span<const Vec3d> position) {
    if (leaf.fitted.surfel.sharp || leaf.covered.empty()) return 0;
    const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(leaf.covered.size()));
    const PerDirection rim = rims_of(reaches_of(leaf, position), static_cast<float>(spacing));
    const auto rim_in = [&](int k) {
        const auto i = static_cast<std::size_t>(k);
        return static_cast<float>(rim[i / FloatV::size()][i % FloatV::size()]);
    };
    int least = 0;
    for (int k = 1; k < kRimDirections; ++k)
        if (rim_in(k) < rim_in(least)) least = k;
    return pack_rim(least, static_cast<double>(rim_in(least)));
}

}  // namespace slim
