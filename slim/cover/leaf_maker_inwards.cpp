// Leaves at borders: smaller, or centred further inwards.

#include "slim/cover/leaf_end.h"
#include "slim/cover/leaf_maker.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

// of rho: how far its centre moves, so that it still covers the point
constexpr double kInwards = 0.45;
constexpr int kMostSmaller = 6;          // times that a leaf becomes smaller to end with its points
constexpr double kClearlySmaller = 0.8;  // share of rho: the data further inwards ask for less

/// Index in the full tree of the point nearest to p within a radius.
std::optional<std::uint32_t> nearest_point(const PointTree& tree, const Vec3d& p, double radius) {
    std::optional<std::uint32_t> best;
    double best_sq = radius * radius;
    tree.for_buckets_in_ball(p, radius, [&](std::size_t first, const PointBucket& bucket) {
        for (std::size_t k = 0; k < PointBucket::kSize; ++k) {
            const double sq =
                sq_length(Vec3d{bucket.x[k], bucket.y[k], bucket.z[k]} + (bucket.origin - p));
            if (sq >= best_sq) continue;
            best_sq = sq;
            best = static_cast<std::uint32_t>(first + k);
        }
    });
    return best;
}

}  // namespace

/// A ladder that goes on past another sheet comes to balls in which its own sheet ends: at the rim
/// of a thin thing. There a leaf is so small that it is drawn hardly beyond its points
/// (notes/0018).
void LeafMaker::end_with_points(const Vec3d& center, const Vec3d& normal, RadiusChoice& choice,
                                LeafWork& work) const {
    if (!choice.past_sheet || !ends_with_points()) return;
    for (int i = 0; i < kMostSmaller; ++i) {
        const double share = share_at_end(fit(center, normal, choice, work, Lists::made));
        if (share == 1 || share * choice.radius < choice.finest) return;
        choice.radius = static_cast<float>(share * choice.radius);
        choice.saturated = false;
    }
}

/// A leaf centred at a border reaches alpha rho beyond the data. One centred further inwards that
/// covers the border point as well reaches beyond it by a quarter of that only; it takes the leaf's
/// place if its own radius allows it. If the radius there is smaller, the border must not have a
/// larger one (a corner sees a quarter of the data only): that radius is returned. Departs from the
/// paper, whose surfels overhang the borders of scans and sharp edges as discs. inwards: unit
std::optional<double> LeafMaker::move_inwards(LeafCandidate& c, const Vec3d& inwards, double lower,
                                              LeafWork& work) const {
    const Vec3d from = block_.position[c.point];
    const double rho = c.surfel.fitted.surfel.support_radius;
    const Vec3d target = from + inwards * (kInwards * rho);
    const auto place = nearest_point(pyramid_.all(), target, 0.5 * kInwards * rho);
    if (!place) return {};
    const PointTree& tree = pyramid_.all();
    const Vec3d center = tree.position(*place);
    const Vec3d normal = normalized(to_double(tree.normal(*place)));
    if (dot(normal, c.surfel.fitted.surfel.frame.normal) < kLeastCos) return {};
    const RadiusChoice choice = choose_radius(*place, normal, c.level, work);
    RadiusChoice moved_choice = choice;
    // Never larger than at the border: it still stands near it.
    moved_choice.radius = std::min<double>(static_cast<float>(choice.radius), rho);
    end_with_points(center, normal, moved_choice, work);
    const double radius = moved_choice.radius;
    if (choice.forced || (edges() != Edges::real && radius < choice.finest)) return {};
    if (radius < kClearlySmaller * rho) return radius;
    if (radius < lower || length(center - from) > 0.5 * radius) return {};
    CoveringSurfel moved = fit_with_air(center, normal, moved_choice, work);
    if (rounds_off(moved) || passes_over(moved)) return kGoldenRatio * radius;
    const auto covers_point = [&](const Covered& p) { return p.point == c.point && p.in_core; };
    if (!moved.explains_center ||
        std::none_of(moved.covered.begin(), moved.covered.end(), covers_point))
        return {};
    c.surfel = std::move(moved);
    c.choice.saturated =
        choice.saturated && radius == static_cast<double>(static_cast<float>(choice.radius));
    c.center = tree.source(*place);
    return {};
}

}  // namespace slim
