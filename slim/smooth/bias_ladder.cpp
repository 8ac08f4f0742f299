#include "slim/smooth/bias_ladder.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr double kTop = 0.25;        ///< of the diagonal: the widest rung
constexpr double kNarrowest = 0.4;   ///< of a leaf's radius: less than its own fit uses
constexpr double kSearch = 8;        ///< of a leaf's radius: where points enough are looked for
constexpr double kNoises = 5;        ///< narrower discs than so many noises show noise alone
constexpr double kPlain = 20;        ///< times the variance: more squared bias ends the climb
constexpr double kMostPoints = 8192; ///< of a rung; more are thinned

/// What is said of a rung; all points know its middle better than a thinning,
/// of which `share` are here.
void write_rung(const WideFit& fit, double share, std::size_t k, BiasLadder& out) {
    out.sq_error[k] = static_cast<float>(fit.sq_error * share);
    out.sq_bias[k] = static_cast<float>(fit.sq_bias);
    out.sq_noise[k] = static_cast<float>(fit.sq_noise / fit.sq_stretch());
    out.lift[k] = static_cast<float>(fit.lift);
    out.sq_lift_error[k] = static_cast<float>(fit.sq_lift_error);
}

}  // namespace

double rung_radius(std::size_t rung, double diagonal) {
    return kTop * diagonal * std::pow(kRungStep, rung);
}

BiasLadder climb_ladder(const Surfel& leaf, double noise, const PointPyramid& points,
                        double diagonal, WideWork& work) {
    BiasLadder out;
    const double rho = leaf.support_radius;
    WideDisc disc{leaf.center + leaf.frame.normal * (leaf.polynomial.a[0] * rho), leaf.frame, 0,
                  noise, largest_curvature(leaf.polynomial, rho)};
    std::size_t level = 0;
    for (std::size_t up = 0; up < kRungs; ++up) {
        const std::size_t k = kRungs - 1 - up;
        disc.radius = rung_radius(k, diagonal);
        if (disc.radius < std::max(kNarrowest * rho, kNoises * noise)) continue;
        const auto fit = fit_wide(points.level(level), disc, true, work);
        if (!fit) {
            if (out.has(k + 1) || disc.radius > kSearch * rho) break;
            continue;
        }
        const double height = fit->polynomial.a[0] * disc.radius;
        if (!(length(disc.center + disc.frame.normal * height - leaf.center) < rho)) break;
        if (out.widest == kRungs) out.narrowest = k;
        out.widest = k;
        write_rung(*fit, points.share(level) / points.share(0), k, out);
        if (fit->sq_bias > kPlain * out.sq_error[k] + 3 * fit->sq_bias_error) {
            out.plain = true;
            break;
        }
        put_on(*fit, disc);
        disc.curvature = largest_curvature(fit->polynomial, disc.radius);
        if (fit->n / (kRungStep * kRungStep) > kMostPoints && level + 1 < points.n_levels())
            ++level;
    }
    for (std::size_t k = out.widest; out.widest < kRungs && k-- > 0;)
        out.sq_bias[k] = std::max(out.sq_bias[k + 1], out.sq_error[out.widest]) *
                         static_cast<float>(kBiasGrowth);
    return out;
}

}  // namespace slim
