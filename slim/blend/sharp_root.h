#pragma once

#include "slim/blend/ray_surfel.h"

#include <optional>

namespace slim {

/// A root of a surfel on a ray: of which sheet, where (the sheet's own axes, over rho).
struct SheetRoot {
    double t = 0;           ///< along the local ray, units of rho
    double t_base = 0;      ///< t_world = t_base + rho t
    std::size_t sheet = 0;
    Vec3d local;
};

/// Whether a root of sheet i lies on the joined surface: its own f counts as exactly 0 there.
inline bool on_joined_surface(const Ray& ray, const Surfel& s, std::size_t i, double t_world) {
    const Vec3d x = (ray.origin + ray.direction * t_world - s.center) / s.support_radius;
    return s.sharp->on_surface(i, s.sheet_values(x));
}

/// The root of the joined function F of a sharp surfel inside the ball of `trim` rho, at t >= t_lo,
/// for which `cost(t)` is least. F is zero where a sheet is and the others agree (SharpSheets).
template <class Cost>
std::optional<SheetRoot> best_joined_root(const Ray& ray, const Surfel& s, double trim, double t_lo,
                                          Cost&& cost) {
    std::optional<SheetRoot> best;
    for (std::size_t i = 0; i < s.n_sheets(); ++i) {
        const LocalRay local = local_ray(ray, s, i);
        if (!local.meets_ball(trim)) return std::nullopt;
        const double half = local.half_chord(trim);
        const double lo = std::max(-half, t_lo);
        const auto roots = ray_roots(ray_polynomial(local, s.sheet_polynomial(i)), lo, half);
        for (int k = 0; k < roots.n; ++k) {
            const double t = roots.t[static_cast<std::size_t>(k)];
            if (best && !(cost(t) < cost(best->t))) continue;
            if (!on_joined_surface(ray, s, i, local.t_base + s.support_radius * t)) continue;
            best = SheetRoot{t, local.t_base, i, local.base + local.direction * t};
        }
    }
    return best;
}

}  // namespace slim
