#include "raytrace/project/patch_bounds.h"

namespace slim {
namespace {

DoubleV root_or_zero(const DoubleV& x) { return stdx::sqrt(stdx::max(x, DoubleV(0.0))); }

}  // namespace

Heading::Heading(const Vec3D& normal)
    : along(normal.z), across(root_or_zero(1.0 - normal.z * normal.z)) {}

DoubleV PatchBounds::support(const Heading& h, bool forth) const {
    const DoubleV along = forth ? h.along : -h.along, sq_radius = radius * radius;
    // Where the ball's own extreme is cut off, by one plane or the other: the rim there.
    const auto rim = [&](const DoubleV& height) {
        return along * height + h.across * root_or_zero(sq_radius - height * height);
    };
    const DoubleV extreme = along * radius;
    return select<DoubleV>(extreme > high, rim(high),
                           select<DoubleV>(extreme < low, rim(low), radius));
}

PatchBounds patch_bounds(const SurfelLanes& s, double share) {
    const auto& a = s.a;
    const double sq_share = share * share;
    const DoubleV zero(0.0), mean = 0.5 * (a[3] + a[5]), half = 0.5 * (a[3] - a[5]);
    const DoubleV spread = stdx::sqrt(half * half + 0.25 * a[4] * a[4]);
    // The largest u^2 v on the unit circle is 2 / sqrt(27).
    const DoubleV third =
        stdx::abs(a[6]) + stdx::abs(a[9]) + 0.385 * (stdx::abs(a[7]) + stdx::abs(a[8]));
    const DoubleV tilt = stdx::sqrt(a[1] * a[1] + a[2] * a[2]);
    const DoubleV either = share * (tilt + sq_share * third) + 1e-4;
    const DoubleV low = a[0] - either + sq_share * stdx::min(zero, mean - spread);
    const DoubleV high = a[0] + either + sq_share * stdx::max(zero, mean + spread);
    const auto within = [&](const DoubleV& x) {
        return stdx::min(stdx::max(x, DoubleV(-share)), DoubleV(share)) * s.radius;
    };
    return {share * s.radius, within(low), within(high)};
}

}  // namespace slim
