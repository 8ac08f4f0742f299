#pragma once

#include "slim/base/frame.h"
#include "slim/base/vec.h"
#include "slim/model/height_hessian.h"
#include "slim/model/polynomial.h"
#include "slim/model/rim.h"
#include "slim/model/sharp_sheets.h"

#include <array>
#include <cstddef>
#include <memory>

namespace slim {

/// One surfel (Ohtake 2005 eq. (1)), decoded to doubles. The surface inside the ball is
/// f(x) = w - P(u, v) = 0 with (u, v, w) = frame.local_from_world(x - center) / support_radius; at
/// an edge or a corner several such functions joined by max or min (SharpSheets).
struct Surfel {
    Vec3d center;           ///< local frame of the job (world minus the job's origin)
    double support_radius;  ///< rho
    Frame<double> frame;    ///< normal outwards
    Polynomial<double> polynomial;
    int degree = 2;         ///< what it was fitted with, after fallbacks: 0..3
    /// further sheets; null: smooth, as nearly all are
    std::shared_ptr<const SharpSheets> sharp = nullptr;

    PackedRims rims = {};  ///< of smooth surfels, in the axes of `frame`
    /// what is better known of a smooth surfel's second derivatives than its polynomial tells
    /// (slim/blend/leaf_hessians.h); null: nothing
    const HeightHessian* hessian = nullptr;

    std::size_t n_sheets() const { return sharp ? sharp->n_sheets() : 1; }
    const Frame<double>& sheet_frame(std::size_t i) const {
        return i == 0 ? frame : sharp->extra[i - 1].frame;
    }
    const Polynomial<double>& sheet_polynomial(std::size_t i) const {
        return i == 0 ? polynomial : sharp->extra[i - 1].polynomial;
    }
    /// f_i at x, relative to the centre and over rho, world axes.
    double sheet_value(std::size_t i, const Vec3d& x) const {
        const Vec3d local = sheet_frame(i).local_from_world(x);
        return local.z - sheet_polynomial(i).value(local.x, local.y);
    }
    /// All f_i at x; those beyond n_sheets() are 0.
    std::array<double, kMostSheets> sheet_values(const Vec3d& x) const {
        std::array<double, kMostSheets> f{};
        for (std::size_t i = 0; i < n_sheets(); ++i) f[i] = sheet_value(i, x);
        return f;
    }
    /// The joined function at x: about the distance to the surface over rho, positive outside.
    double value(const Vec3d& x) const {
        return sharp ? sharp->joined(sheet_values(x)) : sheet_value(0, x);
    }
    /// Number of the sheet that makes the surface nearest x.
    std::size_t active_sheet(const Vec3d& x) const {
        return sharp ? sharp->active(sheet_values(x)) : 0;
    }
    /// Gradient of f_i at x (as value), world axes, times rho: of length >= 1, pointing outwards.
    Vec3d sheet_gradient(std::size_t i, const Vec3d& x) const {
        const Vec3d local = sheet_frame(i).local_from_world(x);
        const Polynomial<double>& p = sheet_polynomial(i);
        return sheet_frame(i).world_from_local(
            {-p.d_u(local.x, local.y), -p.d_v(local.x, local.y), 1.0});
    }
};

/// The share of rho in which stage 1 looks for the first hit (alpha, paper sec. 3).
inline constexpr double kTrim = 2.0 / 3.0;
/// The share of rho in which the renderers look for the first hit. Departs from the paper, whose
/// alpha is kTrim for cover and hit alike: a point is covered within kTrim, and the surface between
/// two such points may lie outside every core. The margin closes these gaps of single pixels: of
/// igea's 37 in three views of 1600x1200 two are left, of bunny_raw's 14 four; a smaller core of
/// the cover does it for 27 % more leaves.
inline constexpr double kHitTrim = 0.72;
/// The same of sharp surfels: points bear their sheets out up to kTrim only
/// (slim/fit/sharp_filled.h). Beyond it they go straight on past what the points show, and stand
/// out of the outline; nearer, gaps open in faces (slim/fit/notes/0014).
inline constexpr double kSharpHitTrim = 0.7;
/// The one of the two that a surfel has.
inline double hit_trim(bool is_sharp) { return is_sharp ? kSharpHitTrim : kHitTrim; }
inline double hit_trim(const Surfel& s) { return hit_trim(s.sharp != nullptr); }
/// The share of rho up to which a point belongs to a surfel: one farther off is neither covered by
/// it nor blended with it, however poor its fit.
inline constexpr double kBelongs = 0.3;
/// Least overlap of a covered point (gamma, paper sec. 2).
inline constexpr double kCoverage = 0.1;
/// Golden ratio g of the radius ladder (paper eq. (5)).
inline constexpr double kGoldenRatio = 0.61803398874989484820;

}  // namespace slim
