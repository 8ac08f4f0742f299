// Larger balls for leaves that a fold, another sheet or a plate's other side keeps small.

#include "slim/cover/leaf_maker.h"
#include "slim/cover/wider_balls.h"

#include <cmath>

namespace slim {
namespace {

constexpr double kWantedOfWide = 24;     // points a coefficient: no more are asked for
// Of a leaf in noise that takes a larger ball past a plate's other side:
constexpr double kPlateFitted = 0.08;    // eps / rho,
constexpr double kPlateNoise = 1.2;      // eps^2 over the typical noise,
constexpr double kPlateLean = 0.06;      // its lean (0.2 at a border),
constexpr double kPlateSideways = 0.03;  // and the share of its points that face
                                         // neither its way nor the other

}  // namespace

template <class Accepts>
void LeafMaker::take_wider(LeafCandidate& c, const Vec3d& center, double n_wanted, LeafWork& work,
                           const Accepts& accepts) const {
    const int degree = rules_.ladder.choose_degree ? rules_.usual_degree() : c.choice.degree;
    const auto n = static_cast<std::size_t>(n_wanted * n_coefficients(degree));
    const auto radii = wider_radii(pyramid_.all(), center, c.choice.radius,
                                   ladder_.rung_radius(rules_.top_rung()), n, work.wide);
    for (const float radius : radii) {
        BallPoints<double>& ball = work.exact.ball;
        shrink_ball(work.wide, static_cast<double>(radius), ball);
        if (!accepts(ball)) continue;
        c.choice.radius = static_cast<double>(radius);
        c.choice.widened = true;
        return;
    }
}

/// Gives a leaf whose ladder a fold or another sheet ended the largest of a few larger balls that
/// is well fitted and stands nowhere in the air (notes/0012).
void LeafMaker::widen(LeafCandidate& c, const Vec3d& center, const Vec3d& normal,
                      LeafWork& work) const {
    take_wider(c, center, kWantedOfWide, work, [&](BallPoints<double>& ball) {
        CoveringSurfel leaf =
            fit_gathered_surfel(pyramid_.all(), center, normal, c.choice.degree, false,
                                rules_.noise_variance, ball, edges(), Lists::left_out);
        if (!is_thin_enough(leaf)) return false;  // its points are not asked for
        list_points(pyramid_.all(), ball, rules_.noise_variance, leaf);
        if (!is_well_fitted(leaf) || rounds_off(leaf) || passes_over(leaf) ||
            (rules_.sharp && has_edge_signs(leaf)))
            return false;
        leaf.air = air_places(leaf.fitted.surfel, ball);
        return ends_before_air(leaf);
    });
}

/// The same in noise, where single points do not say what stands in the air, for leaves that the
/// other side of a thin plate limits (notes/0015): past it where hardly any point faces sideways,
/// as beyond an edge, and noise alone is left.
void LeafMaker::widen_over_plate(LeafCandidate& c, const Vec3d& center, const Vec3d& normal,
                                 LeafWork& work) const {
    const double of_both_sides = 2 * kWantedOfWide;
    take_wider(c, center, of_both_sides, work, [&](BallPoints<double>& ball) {
        if (share_sideways(ball, average_normal(ball, 1, normal).normal) > kPlateSideways)
            return false;
        const CoveringSurfel leaf =
            fit_gathered_surfel(pyramid_.all(), center, normal, c.choice.degree, false,
                                rules_.noise_variance, ball, edges());
        const double eps = leaf.fitted.fit_error;
        return leaf.explains_center && length(leaf.lean) <= kPlateLean &&
               eps <= kPlateFitted * leaf.fitted.surfel.support_radius &&
               eps * eps <= kPlateNoise * rules_.typical_variance;
    });
}

}  // namespace slim
