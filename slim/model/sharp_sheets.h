#pragma once

#include "slim/base/frame.h"
#include "slim/model/polynomial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace slim {

/// As many faces may meet at a corner.
inline constexpr std::size_t kMostSheets = 6;
/// As many sheets hold every corner of three faces; more are for those of more.
inline constexpr std::size_t kUsualSheets = 3;

/// A sheet reaches beyond the edge by this share of rho, for rounding: else a ray through the very
/// edge could find each sheet ended just before the other begins.
inline constexpr double kEdgeTolerance = 1e-6;

/// One height field of a surfel: f(x) = w - P(u, v), (u, v, w) = frame.local_from_world(x - center)
/// / rho.
struct Sheet {
    Frame<double> frame;
    Polynomial<double> polynomial;
};

/// How two functions become one: the solid (f <= 0) is what both share (max: a convex edge) or what
/// either holds (min: a concave one).
enum class Join : unsigned char { max, min };

template <class T>
T join(Join how, const T& a, const T& b) {
    using std::max;
    using std::min;
    return how == Join::max ? max(a, b) : min(a, b);
}

/// The further sheets of a sharp surfel, whose own frame and polynomial are sheet 0:
///     F = outer(f_0, f_1) with two sheets, F = outer(f_0, inner(f_1, f_2, ...)) with more,
/// which holds every corner of three faces: all edges convex (max, max), all concave (min, min), or
/// one of them unlike the two others (that pair is joined by `inner`); and of more faces the peaks
/// (max, max), the pits (min, min) and those with one face that cuts all others off.
struct SharpSheets {
    std::array<Sheet, kMostSheets - 1> extra;
    std::size_t n_extra = 1;
    Join outer = Join::max, inner = Join::max;

    std::size_t n_sheets() const { return n_extra + 1; }
    /// F from the sheets' values.
    template <class T>
    T joined(const std::array<T, kMostSheets>& f) const {
        T rest = f[1];
        for (std::size_t k = 2; k <= n_extra; ++k) rest = join(inner, rest, f[k]);
        return join(outer, f[0], rest);
    }
    /// Whether a point on sheet i is on the joined surface: F stays 0 with f_i set to exactly 0.
    bool on_surface(std::size_t i, std::array<double, kMostSheets> f) const {
        f[i] = 0;
        return std::abs(joined(f)) <= kEdgeTolerance;
    }
    /// The sheet that F takes its value from.
    std::size_t active(const std::array<double, kMostSheets>& f) const {
        const double value = joined(f);
        std::size_t k = 0;
        while (k < n_extra && value != f[k]) ++k;
        return k;
    }
};

}  // namespace slim
