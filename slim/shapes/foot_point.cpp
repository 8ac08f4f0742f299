#include "slim/shapes/foot_point.h"

#include "slim/shapes/nearest_found.h"
#include "slim/shapes/nearest_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

/// How much farther than |f| / |grad f| a foot may lie without a second look.
constexpr double kExpected = 1.2;
/// Distances that pictures and PLYs of floats hold, and whose squares can be summed.
constexpr double kMostDiagonals = 1e30;

FootPoint closed_form(const Shape& shape, const Vec3d& x) {
    const Vec3d y = shape.foot(x);
    return {y, std::copysign(length(x - y), shape.value(x)),
            sq_length(shape.jet(y).gradient()) > 0};
}

/// Where a fan of rays from x first meets the surface within `reach`: the nearest such point.
std::optional<Vec3d> first_met(const Shape& shape, const Vec3d& x, double value, double reach) {
    constexpr int kRays = 96, kSteps = 24, kHalvings = 40;
    std::optional<Vec3d> met;
    for (int i = 0; i < kRays; ++i) {
        // Fibonacci's spiral: even over the sphere.
        const double z = 1 - (2 * i + 1.0) / kRays, r = std::sqrt(1 - z * z),
                     turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const Vec3d way{r * std::cos(turn), r * std::sin(turn), z};
        const auto is_past = [&](double t) { return shape.value(x + way * t) * value <= 0; };
        int k = 1;
        while (k <= kSteps && !is_past(reach * k / kSteps)) ++k;
        if (k > kSteps) continue;
        double lo = reach * (k - 1) / kSteps, hi = reach * k / kSteps;
        for (int h = 0; h < kHalvings; ++h) (is_past((lo + hi) / 2) ? hi : lo) = (lo + hi) / 2;
        met = x + way * hi;
        reach = hi;
    }
    return met;
}

/// Whether no nearer point lies beside the foot: x is not beyond a centre of curvature there.
bool is_least(const Shape& shape, const FootPoint& foot) {
    const SurfacePoint at = surface_point(shape.jet(foot.point));
    return std::min(1 + foot.signed_distance * at.k1, 1 + foot.signed_distance * at.k2) > -1e-6;
}

/// f at x; beside it where a formula has no value, in the middle of the bumpy sphere.
double value_near(const Shape& shape, const Vec3d& x) {
    const double value = shape.value(x), aside = 1e-9 * shape.bounds.diagonal();
    return std::isnan(value) ? shape.value(x + Vec3d{aside, aside, aside}) : value;
}

}  // namespace

FootPoint foot_point(const Shape& shape, const Vec3d& x) {
    if (shape.foot) return closed_form(shape, x);
    const Jet2 f = shape.jet(x);
    const Vec3d g = f.gradient();
    const double lambda = f.value / sq_length(g), tiny = 1e-12 * shape.bounds.diagonal();
    NearestFound nearest(shape, x);
    if (const auto newton = newton_foot(shape, x, x - g * lambda, lambda))
        nearest.add(*newton, true);
    nearest.add_from(gradient_projection(shape, x));
    // Farther than the value at x lets expect: past an edge, or through a thin part.
    if (nearest.distance() > kExpected * std::abs(f.value) / length(g) + tiny)
        if (const auto met = first_met(shape, x, f.value, nearest.distance()))
            nearest.add_from(*met);
    return {nearest.point(), std::copysign(nearest.distance(), f.value), nearest.is_stationary()};
}

std::optional<FootPoint> nearest_point(const Shape& shape, const Vec3d& x) {
    const double diagonal = shape.bounds.diagonal(), away = length(x - shape.bounds.center());
    if (!(away < kMostDiagonals * diagonal)) return std::nullopt;
    if (shape.foot) return closed_form(shape, x);
    std::optional<FootPoint> foot;
    if (away <= diagonal) foot = foot_point(shape, x);
    if (foot && foot->converged && is_least(shape, *foot)) return foot;
    if (shape.open) return std::nullopt;
    const auto found = search_nearest(shape, x, foot ? &foot->point : nullptr);
    if (!found) return std::nullopt;
    return FootPoint{found->point, std::copysign(length(x - found->point), value_near(shape, x)),
                     found->stationary};
}

double signed_distance(const Shape& shape, const Vec3d& x) {
    return foot_point(shape, x).signed_distance;
}

}  // namespace slim
