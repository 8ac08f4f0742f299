// Leaves that would bridge a void of the data: ended before it, moved away from it, or smaller.

#include "slim/cover/leaf_maker.h"
#include "slim/cover/leaf_rim.h"
#include "slim/cover/leaf_voids.h"
#include "slim/cover/void_ends.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr int kMostTries = 8;
constexpr double kNear = 0.24;  // over rho: an end that leaves less than two thirds of the disc
constexpr double kLeastShare = 0.7;    // a leaf that was moved becomes no smaller for a rim's step
constexpr double kBitLarger = 1.002;  // lest the step is too short by rounding

}  // namespace

/// What a leaf bridges, by all points of its ball.
LeafVoids LeafMaker::voids_in(const CoveringSurfel& leaf, LeafWork& work) const {
    const Surfel& s = leaf.fitted.surfel;
    gather_ball(pyramid_.all(), s.center, s.support_radius, work.exact.ball);
    std::vector<SetAside<double>> aside;
    set_contrary_aside(work.exact.ball, s.frame.normal, aside);
    return voids_of(leaf, work.exact.ball, rims_of(leaf));
}

/// The same leaf about another centre, or with another radius.
void LeafMaker::make_again(LeafCandidate& c, double radius, LeafWork& work) const {
    c.choice.widened = false;
    c.choice.saturated = c.choice.saturated && radius >= c.surfel.fitted.surfel.support_radius;
    RadiusChoice choice = c.choice;
    choice.radius = static_cast<float>(radius);
    const Vec3d normal = normalized(to_double(block_.normal[c.center]));
    c.surfel = fit_with_air(block_.position[c.center], normal, choice, work);
}

/// Centres a leaf farther from a void in that direction; false if none there covers its point.
bool LeafMaker::move_from(LeafCandidate& c, int direction, double lower, LeafWork& work) const {
    const auto [u, v] = rim_direction(direction);
    const Vec3d inwards = c.surfel.fitted.surfel.frame.world_from_local({-u, -v, 0});
    move_inwards(c, inwards, lower, work);
    return c.center != c.point;
}

/// Ends a leaf before what it would bridge (notes/0024). c.leaf becomes false if it must be smaller
/// than `lower` for that.
void LeafMaker::keep_voids(LeafCandidate& c, double lower, LeafWork& work) const {
    if (rules_.windows) return;
    bool may_move = c.center == c.point;
    for (int i = 0; i < kMostTries && may_bridge(c.surfel); ++i) {
        const LeafVoids found = voids_in(c.surfel, work);
        if (!found.any) return;
        const double rho = c.surfel.fitted.surfel.support_radius;
        double share = kGoldenRatio;
        if (found.n_ends > 0 && found.ends[0].reach < kNear && std::exchange(may_move, false) &&
            move_from(c, found.ends[0].direction, lower, work))
            continue;
        if (found.n_ends > 0 && end_at_voids(found, c.point, c.surfel, share)) return;
        const bool fits_a_step = share < 1 && share >= kLeastShare;
        if (c.center != c.point && !fits_a_step)
            c.center = c.point, share = 1;  // back to the point itself
        else
            share = share < 1 ? std::min(kBitLarger * share, 1.0) : kGoldenRatio;
        const double radius = share * rho;
        if (!c.choice.forced && radius < c.choice.finest) return;
        if (radius < lower) {
            make_smaller(c, radius, lower);
            return;
        }
        make_again(c, radius, work);
    }
}

}  // namespace slim
