// Leaves that single points have to themselves, and what other leaves may pass over.

#include "slim/blend/blend.h"
#include "slim/cover/leaf_maker.h"
#include "slim/cover/leaf_rim.h"
#include "slim/cover/sound_normal.h"
#include "slim/model/surfel_encoder.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace slim {
namespace {

constexpr int kMostRungs = 3;        // that it may be smaller than the finest ball
constexpr double kNearEnough = 0.5;  // of what no point may be off: so
                                     // near its point a leaf must pass

}  // namespace

/// Whether a leaf passes over points of its core that are farther off than any may be (notes/0016).
bool LeafMaker::passes_over(const CoveringSurfel& leaf) const {
    if (!rules_.refits) return false;
    const auto farthest = static_cast<float>(rules_.farthest() / leaf.fitted.surfel.support_radius);
    return std::any_of(leaf.covered.begin(), leaf.covered.end(),
                       [&](const Covered& p) { return p.in_core && std::abs(p.off) > farthest; });
}

/// Whether it does though its search admits a smaller ball.
bool LeafMaker::is_too_large(const LeafCandidate& c) const {
    return !c.choice.forced && kGoldenRatio * c.choice.radius >= c.choice.finest &&
           passes_over(c.surfel);
}

std::optional<CoveringSurfel> LeafMaker::make_own(std::uint32_t point, int n_before,
                                                  LeafWork& work) const {
    const Vec3d p = block_.position[point];
    const Vec3d normal = has_stray_normals(rules_)
                             ? sound_normal(pyramid_.all(), place_[point])
                             : normalized(to_double(block_.normal[point]));
    RadiusChoice choice = choose_radius(place_[point], normal, rules_.last_level, work);
    if (choice.isolated) return {};
    const double finest = choice.forced ? choice.radius : choice.finest;
    choice.forced = choice.widened = true;  // the plain fit
    for (int rung = n_before; rung < kMostRungs; ++rung) {
        choice.radius = static_cast<float>(finest * std::pow(kGoldenRatio, rung));
        CoveringSurfel leaf = fit_with_air(p, normal, choice, work);
        Surfel& s = leaf.fitted.surfel;
        s.rims = rims_of(leaf);
        s = level_linear(s);  // as the file's
        if (n_before > 0) {
            leaf.fitted.fit_error =
                std::hypot(leaf.fitted.fit_error, s.polynomial.a[0] * s.support_radius);
            s.polynomial.a[0] = 0;
        }
        leaf.fitted.point_id = block_.id[point];
        const Surfel* alone = &s;
        const auto at = project_along(p, normal, std::span(&alone, 1));
        if (at && std::abs(at->t) <= kNearEnough * rules_.farthest()) return leaf;
    }
    return {};
}

std::optional<CoveringSurfel> LeafMaker::make_usual(std::uint32_t point, LeafWork& work) const {
    LeafCandidate c;
    c.point = c.center = point;
    c.level = rules_.last_level;
    choose(c, work);
    if (c.choice.isolated) return {};
    c.leaf = true;
    make(c, 0, work);
    if (!c.leaf || !c.surfel.explains_center) return {};
    FittedSurfel& f = c.surfel.fitted;
    f.surfel.rims = rims_of(c.surfel);
    f.point_id = block_.id[c.center];
    f.flags = static_cast<std::uint8_t>((c.choice.forced ? kForced : 0) |
                                        (c.choice.limited ? kLimited : 0));
    return std::move(c.surfel);
}

}  // namespace slim
