#pragma once

#include "slim/fit/local_fit.h"
#include "slim/fit/sharp_fit.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

namespace slim {

/// Residuals up to so many eps belong to a sheet.
inline constexpr double kExplained = 4;

/// A sharp fit while it is improved, and what its sheets are at places of the ball (relative to the
/// centre, over the radius).
class FittedSheets {
public:
    SharpFit fit;

    /// Height of a place over a sheet, over the radius.
    double value(std::size_t k, const Vec3d& x) const {
        const Vec3d local = fit.frame[k].local_from_world(x);
        return local.z - fit.polynomial[k].value(local.x, local.y);
    }
    /// Of a sheet's gradient at x to a unit normal.
    double cosine(std::size_t k, const Vec3d& x, const Vec3d& n) const {
        if (plane_[k]) return dot(plane_[k]->gradient, n) / plane_[k]->length;
        const Vec3d local = fit.frame[k].local_from_world(x);
        const Polynomial<double>& a = fit.polynomial[k];
        const Vec3d g{-a.d_u(local.x, local.y), -a.d_v(local.x, local.y), 1};
        return dot(fit.frame[k].world_from_local(g), n) / length(g);
    }
    /// The sheet whose normal at x is nearest to n, and their cosine; 1 for a point without a
    /// normal.
    std::pair<std::size_t, double> nearest_normal(const Vec3d& x, const Vec3d& n) const {
        std::pair<std::size_t, double> best{0, -1};
        for (std::size_t k = 0; k < fit.n_sheets; ++k)
            if (const double c = cosine(k, x, n); c > best.second) best = {k, c};
        if (!(sq_length(n) > 0)) best.second = 1;
        return best;
    }

    /// A sheet becomes that fit in its frame.
    void set(std::size_t k, const LocalFit& to) {
        const Polynomial<double>& a = fit.polynomial[k] = to.polynomial;
        plane_[k].reset();
        if (std::any_of(a.a.begin() + 3, a.a.end(), [](double c) { return c != 0; })) return;
        const Vec3d g{-a.a[1], -a.a[2], 1};
        plane_[k] = Plane{fit.frame[k].world_from_local(g), length(g)};
    }
    /// Sheet k changes places with the first.
    void put_first(std::size_t k) {
        std::swap(fit.frame[0], fit.frame[k]);
        std::swap(fit.polynomial[0], fit.polynomial[k]);
        std::swap(plane_[0], plane_[k]);
    }

private:
    /// The gradient of a sheet without terms of higher order, world axes, and its length.
    struct Plane {
        Vec3d gradient;
        double length;
    };
    std::array<std::optional<Plane>, kMostSheets> plane_;
};

}  // namespace slim
