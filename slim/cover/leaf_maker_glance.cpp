// What can be told of a leaf before its fit, or before its points are listed.

#include "slim/cover/leaf_maker.h"
#include "slim/cover/scatter.h"

#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr double kEnough = 1200;      // points of a sample at least, as the usual spacing has them
constexpr double kSure = 6000;        // of one that tells whether the centre is explained
constexpr double kFewerThan = 0.4;    // share of the ball: a larger sample takes as long as the fit
constexpr double kErrors = 5;         // standard errors of a sample's eps
                                      // that it must be too thick by
constexpr double kEffective = 0.4;    // points that count under G, over
                                      // those of a ball (0.44 of a disc)
constexpr double kLeast = 300;        // points that a sample must hold indeed
constexpr double kBorder = 0.1;       // lean of a leaf that may move
                                      // inwards, and then cover its point
// over rho: then no point is explained that lies as near as to count as the centre
constexpr double kClearlyOff = 2e-3;

}  // namespace

/// Where noise is thick, centres far out in it have balls of many thousand points, which either are
/// too thick for their radius or do not explain their centre (pipeline/notes/0003).
LeafMaker::Glance LeafMaker::glance(const LeafCandidate& c, const Vec3d& center,
                                    const Vec3d& normal, LeafWork& work) const {
    const double rho = c.choice.radius;
    const double n = std::numbers::pi * rho * rho / (spacing_ * spacing_);
    if (!c.sparse || c.choice.forced || rules_.is_sample() || rules_.refits || rules_.windows)
        return Glance::undecided;
    std::size_t level = pyramid_.n_levels();
    for (const double wanted : {kEnough, kSure}) {
        const std::size_t before = level;
        level = pyramid_.n_levels() - 1;
        while (level > 0 && n * pyramid_.share(level) < wanted) --level;
        if (pyramid_.share(level) > kFewerThan) break;
        if (level == before) continue;
        const CoveringSurfel s =
            fit_surfel(pyramid_.level(level), center, normal, rho, c.choice.degree, false,
                       rules_.noise_variance, work.exact.ball, edges(), Lists::left_out);
        const auto n_sample = static_cast<double>(work.exact.ball.n);
        const double thicker = 1 + kErrors / std::sqrt(2 * kEffective * n_sample);
        if (n_sample < kLeast) break;
        if (is_thicker(s, false, true, is_clean(), thicker)) return Glance::scatter;
        const bool may_move = length(s.lean) > kBorder || c.choice.limited;
        if (n_sample >= kSure / 2 && !may_move && misses_center(s.fitted, rules_.noise_variance, 0))
            return Glance::unexplained;
    }
    return Glance::undecided;
}

/// Whether a fitted leaf leaves its centre unexplained, so that nobody asks for its points.
bool LeafMaker::leaves_center(const LeafCandidate& c) const {
    return !rules_.refits && misses_center(c.surfel.fitted, rules_.noise_variance, kClearlyOff);
}

}  // namespace slim
