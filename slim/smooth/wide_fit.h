#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "slim/fit/local_fit.h"
#include "slim/model/polynomial.h"
#include "slim/neighbors/point_tree.h"

#include <array>
#include <optional>
#include <vector>

namespace slim {

/// A share of a wide fit's radius: where the surface is taken from it. Fits this far apart blend
/// over twice it.
inline constexpr double kCore = 0.25;

/// Workspace of one thread.
struct WideWork {
    BallPoints<float> ball;
    std::vector<SetAside<float>> aside;
};

/// A disc to fit to, in the plane of a frame.
struct WideDisc {
    Vec3d center;
    Frame<double> frame;
    double radius = 0;
    double noise = 0;      ///< RMS of a height, length; sets how far
                           ///< off the surface points are looked for
    double curvature = 0;  ///< of the surface, the larger one's magnitude, 1 / length; the same
};

/// A quadratic fitted with equal weights to all points about a place, and how well the middle is
/// known: what counts for a blend of such fits a core apart, where the odd terms of their errors
/// cancel (notes/0003).
struct WideFit {
    Polynomial<double> polynomial;  ///< in the frame given, coordinates over the radius
    double n = 0;                   ///< points
    double sq_noise = 0;            ///< of a height, length^2; no less than the rounding of floats
    double sq_error = 0;            ///< variance of the middle's height by
                                    ///< noise, mean over the core, length^2
    double sq_rounding = 0;         ///< what is left of sq_noise where
                                    ///< points have none: that of floats
    double spread = 0;  ///< that variance over sq_noise / n; 4 to 5 where points are all around
    /// Squared bias there by the even terms of degrees 3 and 4, less the share of them that noise
    /// explains, and the standard error of that; may be negative. Zero unless asked for,
    /// as the next four.
    double sq_bias = 0, sq_bias_error = 0;
    /// What degrees 3 and 4 add to the height where such fits are blended (notes/0009), a length,
    /// and its variance by noise.
    double lift = 0, sq_lift_error = 0;
    /// What they add to the slopes in the middle, which odd terms bias, and the variance of the
    /// vector by noise.
    std::array<double, 2> turn{};
    double sq_turn_error = 0;

    /// Mean over the disc of 1 + slope^2: how much more the noise of heights is than that across
    /// the surface.
    double sq_stretch() const;
};

/// The magnitude of the larger second derivative of a height field in the middle,
/// coordinates over `radius`.
double largest_curvature(const Polynomial<double>& p, double radius);

/// Least squares of the points whose feet in the frame's plane are nearer to the centre than the
/// radius, out to 6 noises and the surface's own sag beyond the ball of that radius (a ball cuts
/// off what bends away or is thick towards its rim); those whose normals are below kLeastCos to the
/// frame's do not count. With `ahead` also looks at degrees 3 and 4. Nothing if there are fewer
/// than 60 points (18 without `ahead`), none within half the radius, or no such polynomial goes
/// through them. Cost: one pass (two where the residual is lost to cancellation),
/// a factor of 15 rows.
std::optional<WideFit> fit_wide(const PointTree& points, const WideDisc& disc, bool ahead,
                                WideWork& work);

/// Puts a disc on a fit to it, and turns it to the fit there, where it is farther off than a
/// quarter of its noise. Returns whether it was.
bool put_on(const WideFit& fit, WideDisc& disc);

}  // namespace slim
