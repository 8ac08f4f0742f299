#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_normal.h"
#include "slim/fit/ball_points.h"
#include "slim/model/polynomial.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Why a fit has a lower degree than asked (NUMERICS 2.4), in the order they are tried; the last of
/// forced leaves, which take the lowest degree that explains their points.
enum class Fallback : std::uint8_t { none, few_points, rank, steep, plane, lower_explains };
inline constexpr std::size_t kFallbacks = 6;
const char* fallback_name(Fallback fallback);

/// A height field fitted to one ball.
struct LocalFit {
    Polynomial<double> polynomial;  ///< in the fit's frame, coordinates divided by its radius
    int degree = 0;
    double sq_error = 0;     ///< eps^2, unbiased: weighted mean squared
                             ///< residual / (1 - K / n_eff), length^2
    /// What the terms of the next degree would take off eps^2 beyond the share of them that noise
    /// explains, and the standard error of that (length^2; fit_ball leaves both 0).
    /// May be negative.
    double sq_missed = 0, sq_missed_error = 0;
    /// What these terms would take off the mean squared slope error, times rho^2,
    /// where the normals count; else 0.
    double sq_missed_slope = 0;
    /// Mean squared length of what slopes are off the fit, without what the next degree would take
    /// of it, where the normals count; else 0.
    double sq_slope_error = 0;
    double n_effective = 0;  ///< (sum G)^2 / sum G^2
    std::size_t n_points = 0;
    Fallback fallback = Fallback::none;
};

/// How many of the points set aside lie off the fit, farther than `tolerance` (length): a fold or
/// another sheet. The rest have a bad normal only, as scans hold many at depth edges.
template <class T>
std::size_t count_off_sheet(const BallPoints<T>& points, std::span<const SetAside<T>> aside,
                            const Frame<double>& frame, const LocalFit& fit, double tolerance);

/// What a degree of K coefficients asks of the points besides rank (NUMERICS 2.4): 2 K of them, or
/// K + 2 effective ones as well. Without the latter eps is no estimate: fits that are compared by
/// it, and those of balls that it did not choose, ask for them (slim/cover/notes/0009).
enum class Enough : std::uint8_t { points, freedom };

/// Weighted least squares w = P(u, v) of Ohtake 2005 sec. 2 in `frame`, radius = shrink *
/// points.radius, of the asked degree (1..3) or what NUMERICS 2.4 leaves of it. Never fails: the
/// last resort is the plane through the weighted mean, or through the centre where there is no
/// weight at all. Cost: one pass over the points (two where the residual is lost to cancellation),
/// O(K^3) for the solve.
template <class T>
LocalFit fit_ball(const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                  int degree, Enough enough = Enough::freedom);

/// fit_ball that also looks at the terms of the next degree, in the same pass and factor
/// (notes/0005). Cost: the sums of the next degree.
template <class T>
LocalFit fit_ball_ahead(const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                        int degree);

/// fit_ball_ahead of degrees 1, 2 and 3 (places 0, 1, 2) from one pass and one factor (NUMERICS
/// 2.2); a place whose fit has a lower degree than its own fell back to it.
/// Cost: that of degree 3, and a residual pass for each degree whose residual is lost to
/// cancellation.
template <class T>
std::array<LocalFit, kMaxDegree> fit_every_degree(const BallPoints<T>& points, double shrink,
                                                  const Frame<double>& frame);

/// A fit and how its coefficients answer to noise.
struct SpreadFit {
    LocalFit fit;
    /// Variance of each over that of the heights' noise, coordinates divided by the *gather*
    /// radius; zero beyond the fit's degree.
    std::array<double, kMaxCoefficients> spread{};
};

/// fit_ball of degree 2 or 3 with the spread of its coefficients, from the same pass and factor.
template <class T>
SpreadFit fit_ball_with_spread(const BallPoints<T>& points, double shrink,
                               const Frame<double>& frame, int degree);

/// Whether a patch leaves its ball: |grad P(0)| + max |P_2| + max |P_3| > 4, maxima of the
/// homogeneous parts over the unit circle (of P_3 a bound). Departs from NUMERICS 2.4, rule 3, sum
/// |a_k| > 3, which depends on the axes: the same edge passed when it ran along one and became a
/// plane across it when it ran between them (notes/0008).
bool too_steep(const Polynomial<double>& polynomial);

}  // namespace slim
