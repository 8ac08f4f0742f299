#include "slim/cover/edge_ends.h"

#include "slim/cover/drawn_part.h"
#include "slim/cover/leaf_balls.h"
#include "slim/cover/leaf_reach.h"
#include "slim/cover/leaves_along_curve.h"
#include "slim/cover/surfel_fit.h"
#include "slim/model/rim.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

namespace slim {
namespace {

constexpr double kThin = 0.012;      // eps / rho of sharp leaves that know where their edge is
constexpr double kStandsOut = 0.02;  // over rho: what stands out by less is no flap,
constexpr double kErrors = 3;        // nor by so many eps
constexpr double kFacesAway = -0.2;  // cosine: another side's
constexpr double kSameSide = 0.5;    // cosine of normals of leaves that stand in for each other
constexpr int kRounds = 2;           // rims of a leaf

using Leaves = std::vector<const FittedSurfel*>;

/// A place that a leaf draws, or a point that it covers, in its tangent plane over rho.
struct Drawn {
    double u, v;
    bool stands_out = false;
    bool is_shared = false;  ///< others draw it too
};

/// A smooth leaf that stands out.
struct Standing {
    FittedSurfel* leaf;
    std::vector<Drawn> places;
    Leaves near;
};

/// Whether a place is outside of what the sharp leaves about it show: one that holds it says so,
/// and none whose core holds it shows it.
bool stands_out(const FittedSurfel& leaf, const Vec3d& place, const Leaves& sharp) {
    const double rho = leaf.surfel.support_radius;
    bool found = false;
    for (const FittedSurfel* other : sharp) {
        const Surfel& s = other->surfel;
        const Vec3d x = (place - s.center) / s.support_radius;
        if (!(sq_length(x) < 1)) continue;
        const double off = s.value(x) * s.support_radius,
                     least = kStandsOut * rho + kErrors * (leaf.fit_error + other->fit_error);
        const Vec3d outwards = normalized(s.sheet_gradient(s.active_sheet(x), x));
        if (dot(outwards, leaf.surfel.frame.normal) < kFacesAway) continue;
        if (off > least) found = true;
        else if (sq_length(x) < kTrim * kTrim)
            return false;
    }
    return found;
}

/// Whether another leaf draws what this one draws at a place.
bool is_shared(const FittedSurfel& leaf, const Vec3d& place, const Vec3d& normal,
               const Leaves& near) {
    return std::any_of(near.begin(), near.end(), [&](const FittedSurfel* other) {
        const Surfel& t = other->surfel;
        if (!t.sharp)
            return dot(t.frame.normal, normal) > kSameSide && is_drawn_at(t, place, normal);
        const Vec3d x = (place - t.center) / t.support_radius;
        if (!(sq_length(x) < kSharpHitTrim * kSharpHitTrim)) return false;
        const double most = kStandsOut * leaf.surfel.support_radius +
                            kErrors * (leaf.fit_error + other->fit_error);
        return std::abs(t.value(x)) * t.support_radius <= most;
    });
}

/// The rim that cuts off the most of what stands out and nothing that the leaf alone draws; 0
/// without one. Of several the farthest.
PackedRim best_rim(const std::vector<Drawn>& places) {
    int best = 0, best_step = 0;
    std::ptrdiff_t most = 0;
    for (int k = 0; k < kRimDirections; ++k) {
        const auto [u, v] = rim_direction(k);
        const auto reach = [u = u, v = v](const Drawn& p) { return u * p.u + v * p.v; };
        double alone = 0;  // how far the leaf is needed
        for (const Drawn& p : places)
            if (!p.stands_out && !p.is_shared) alone = std::max(alone, reach(p));
        const int first = std::max(1, static_cast<int>(std::ceil(alone / kRimStep)));
        for (int step = kRimReaches; step >= first; --step) {
            const auto n = std::count_if(places.begin(), places.end(), [&](const Drawn& p) {
                return p.stands_out && reach(p) >= kRimStep * step;
            });
            if (n > most) most = n, best = k, best_step = step;
        }
    }
    return most > 0 ? pack_rim(best, kRimStep * (best_step - 0.5)) : PackedRim{0};
}

Drawn in_plane(const Surfel& s, const Vec3d& place) {
    const Vec3d local = s.frame.local_from_world((place - s.center) / s.support_radius);
    return {local.x, local.y};
}

/// The places of a leaf, if some of them stand out.
std::vector<Drawn> standing_places(const FittedSurfel& leaf, const Leaves& sharp) {
    std::vector<Drawn> out;
    bool some = false;
    for (const Vec3d& place : drawn_places(leaf.surfel)) {
        out.push_back(in_plane(leaf.surfel, place));
        out.back().stands_out = stands_out(leaf, place, sharp);
        some = some || out.back().stands_out;
    }
    if (!some) out.clear();
    return out;
}

Vec3d place_of(const Surfel& s, double u, double v, double off) {
    const Vec3d local{u, v, s.polynomial.value(u, v) + off};
    return s.center + s.frame.world_from_local(local) * s.support_radius;
}

class Ends {
public:
    Ends(const PointTree& points, const NeedlessRules& rules, std::span<BlendResidual> blend,
         std::span<std::uint8_t> n_drawn)
        : points_(points), rules_(rules), blend_(blend), n_drawn_(n_drawn) {}

    /// Gives a leaf its rims; whether it got one.
    bool end(Standing& standing) {
        FittedSurfel& leaf = *standing.leaf;
        Surfel& s = leaf.surfel;
        const CoveringSurfel again = cover_again(points_, leaf, rules_.noise_variance, ball_, {});
        for (Drawn& p : standing.places)
            p.is_shared = is_shared(leaf, place_of(s, p.u, p.v, 0), s.frame.normal, standing.near);
        for (const Covered& c : again.covered)
            if (c.in_core) {
                const double u = static_cast<double>(c.u), v = static_cast<double>(c.v);
                const Vec3d at = place_of(s, u, v, static_cast<double>(c.off));
                standing.places.push_back(
                    {u, v, false, is_shared(leaf, at, s.frame.normal, standing.near)});
            }
        const PackedRims before = s.rims;
        PackedRims rims = before;
        for (int round = 0; round < kRounds && rims.second == 0; ++round) {
            const PackedRim rim = best_rim(standing.places);
            if (rim == 0) break;
            (rims.first == 0 ? rims.first : rims.second) = rim;
            const Rim cut = unpack_rim(rim);
            std::erase_if(standing.places, [&](const Drawn& p) {
                return p.stands_out && cut.u * p.u + cut.v * p.v >= cut.reach;
            });
        }
        if (rims == before) return false;
        add(again, s, -1);
        s.rims = rims;
        add(again, s, 1);
        return true;
    }

private:
    /// Adds a leaf's shares to the blend, or takes them from it.
    void add(const CoveringSurfel& again, const Surfel& s, int sign) {
        const LeafShares shares(s);
        for (const Covered& c : again.covered) {
            const LeafShare share = shares.of(c);
            blend_[share.point].weight += static_cast<float>(sign) * share.weight;
            blend_[share.point].height += static_cast<float>(sign) * share.height;
            std::uint8_t& n = n_drawn_[share.point];
            if (share.is_drawn && n > 0 && n < 255) n = static_cast<std::uint8_t>(n + sign);
        }
    }

    const PointTree& points_;
    const NeedlessRules& rules_;
    std::span<BlendResidual> blend_;
    std::span<std::uint8_t> n_drawn_;
    BallPoints<double> ball_;
};

/// Leaves that may be relied on, and those of them that may end at an edge.
struct Known {
    std::vector<const Surfel*> surfels;
    std::unordered_map<const Surfel*, const FittedSurfel*> fitted;
    std::vector<FittedSurfel*> smooth;
    bool any_sharp = false;

    Known(const NeedlessRules& rules, std::vector<std::vector<FittedSurfel>>& leaves) {
        for (std::vector<FittedSurfel>& piece : leaves)
            for (FittedSurfel& leaf : piece) {
                const bool is_sharp = leaf.surfel.sharp != nullptr;
                any_sharp = any_sharp || is_sharp;
                if (!is_sharp && rules.owns && !rules.owns(leaf.surfel.center)) continue;
                surfels.push_back(&leaf.surfel);
                fitted.emplace(&leaf.surfel, &leaf);
                if (!is_sharp && leaf.surfel.rims.second == 0) smooth.push_back(&leaf);
            }
    }
};

/// A leaf and what it meets of others, if it stands out of the sharp ones among them.
std::optional<Standing> standing_out(FittedSurfel& leaf, const LeafBalls& balls,
                                     const Known& known) {
    std::vector<const Surfel*> meeting;
    append_meeting(leaf.surfel, balls, meeting);
    Standing out{&leaf, {}, {}};
    Leaves sharp;
    for (const Surfel* s : meeting) {
        const FittedSurfel* other = known.fitted.at(s);
        out.near.push_back(other);
        if (s->sharp && other->fit_error < kThin * s->support_radius) sharp.push_back(other);
    }
    if (sharp.empty()) return std::nullopt;
    out.places = standing_places(leaf, sharp);
    if (out.places.empty()) return std::nullopt;
    return out;
}

std::vector<Standing> leaves_that_stand_out(const NeedlessRules& rules,
                                            std::vector<std::vector<FittedSurfel>>& leaves) {
    const Known known(rules, leaves);
    if (!known.any_sharp) return {};
    const auto along = leaves_along_curve(
        known.smooth, [](const FittedSurfel& leaf) -> const Surfel& { return leaf.surfel; });
    std::vector<const Surfel*> surfels;
    for (const FittedSurfel* leaf : along) surfels.push_back(&leaf->surfel);
    std::vector<Standing> out;
    for_leaves_together(surfels, LeafBalls(known.surfels),
                        [&](std::size_t first, std::span<const Surfel* const> together,
                            const LeafBalls& balls) {
                            for (std::size_t k = 0; k < together.size(); ++k)
                                if (auto s = standing_out(*along[first + k], balls, known))
                                    out.push_back(std::move(*s));
                        });
    return out;
}

}  // namespace

std::size_t end_at_edges(const PointTree& points, const NeedlessRules& rules,
                         std::span<BlendResidual> blend, std::span<std::uint8_t> n_drawn,
                         std::vector<std::vector<FittedSurfel>>& leaves) {
    std::vector<Standing> standing = leaves_that_stand_out(rules, leaves);
    Ends ends(points, rules, blend, n_drawn);
    std::size_t n = 0;
    for (Standing& s : standing) n += ends.end(s);
    return n;
}

}  // namespace slim
