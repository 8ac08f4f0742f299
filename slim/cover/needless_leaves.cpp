#include "slim/cover/needless_leaves.h"

#include "slim/base/parallel.h"
#include "slim/cover/drawn_part.h"
#include "slim/cover/leaf_balls.h"
#include "slim/cover/leaves_along_curve.h"
#include "slim/cover/surfel_fit.h"
#include "slim/fit/mdl_energy.h"
#include "slim/model/rim.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>
#include <unordered_set>
#include <utility>

namespace slim {
namespace {

/// Of the price of all the area that a leaf has to itself, in E: more leaves go with more of it, at
/// the cost of normals.
constexpr double kPriceShare = 0.15;
/// Least weight left where the leaf was drawn: with less the others' outermost tails are seen,
/// whose normals are poor.
constexpr float kLeastWeight = 0.06f;
constexpr double kNotTooFar = 0.5;  // of what no point may be off
constexpr double kSameSide = 0.5;   // cosine of normals of leaves that stand in for each other

/// A leaf that the others may do without.
struct Needless {
    std::size_t piece, index;  // in the arrays of leaves
    std::size_t number;        // of all
    std::uint64_t id;          // of its point
    double worse;
    std::vector<LeafShare> shares;
    std::vector<const Surfel*> near;  // others that may draw what it draws
};

using Leaves = std::vector<const Surfel*>;

/// What is drawn by leaves while some of them go.
class Drawn {
public:
    /// Whether others that are left draw all that a leaf draws, its neighbours among them.
    bool is_drawn_by_others(const Surfel& leaf, const Leaves& near) const {
        const Surfel* last = nullptr;  // that drew a place: the next one is mostly its, too
        for (const Vec3d& place : drawn_places(leaf)) {
            const auto draws = [&](const Surfel* t) {
                return dot(t->frame.normal, leaf.frame.normal) > kSameSide &&
                       is_drawn_at(*t, place, leaf.frame.normal) && !gone_.contains(t);
            };
            if (last && draws(last)) continue;
            const auto found = std::find_if(near.begin(), near.end(), draws);
            if (found == near.end()) return false;
            last = *found;
        }
        return true;
    }
    void remove(const Surfel& leaf) { gone_.insert(&leaf); }

private:
    std::unordered_set<const Surfel*> gone_;
};

class Removal {
public:
    Removal(const PointTree& points, const NeedlessRules& rules, std::span<BlendResidual> blend,
            std::span<std::uint8_t> n_drawn)
        : points_(points), rules_(rules), blend_(blend), n_drawn_(n_drawn) {}

    /// Whether its own centre tells that a leaf is needed: most are.
    bool center_needs(const Surfel& leaf, std::uint32_t center) const {
        const auto weight = static_cast<float>(rim_share(leaf.rims, 0, 0));  // G(0) = 1
        return leaf.sharp || n_drawn_[center] < 2 || blend_[center].weight - weight < kLeastWeight;
    }

    std::vector<LeafShare> shares_of(const FittedSurfel& leaf, BallPoints<double>& ball) const {
        const CoveringSurfel again = cover_again(points_, leaf, rules_.noise_variance, ball, {});
        std::vector<LeafShare> out;
        out.reserve(again.covered.size());
        const LeafShares shares(leaf.surfel);
        for (const Covered& p : again.covered) out.push_back(shares.of(p));
        return out;
    }

    /// By how much the sum of squares grows without a leaf; nothing if it is needed.
    std::optional<double> worse_without(const Surfel& leaf,
                                        std::span<const LeafShare> shares) const {
        double worse = 0;
        for (const LeafShare& s : shares) {
            const BlendResidual& all = blend_[s.point];
            const BlendResidual rest{all.weight - s.weight, all.height - s.height};
            if (s.is_drawn && (n_drawn_[s.point] < 2 || rest.weight < kLeastWeight)) return {};
            if (rest.weight < kLeastWeight / 6) continue;  // others' outermost tails alone
            const double before = all.off(), after = rest.off();
            if (std::abs(after) > std::max(kNotTooFar * rules_.farthest, std::abs(before)))
                return {};
            worse += after * after - before * before;
        }
        if (worse > rules_.most_worse * degree_price(leaf.degree)) return {};
        return worse;
    }

    void remove(std::span<const LeafShare> shares) {
        for (const LeafShare& s : shares) {
            blend_[s.point].weight -= s.weight;
            blend_[s.point].height -= s.height;
            if (s.is_drawn) --n_drawn_[s.point];
        }
    }

private:
    const PointTree& points_;
    const NeedlessRules& rules_;
    std::span<BlendResidual> blend_;
    std::span<std::uint8_t> n_drawn_;
};

using Pieces = std::vector<std::vector<FittedSurfel>>;

/// Those that each alone is needless, the one that is needed least first.
std::vector<Needless> candidates_of(const Removal& removal, const NeedlessRules& rules,
                                    const Pieces& leaves,
                                    std::span<const std::uint32_t> centers) {
    tbb::enumerable_thread_specific<BallPoints<double>> balls;
    std::vector<Needless> out;
    std::size_t before = 0;
    for (std::size_t piece = 0; piece < leaves.size(); before += leaves[piece++].size()) {
        std::vector<std::optional<Needless>> found(leaves[piece].size());
        parallel_blocks(found.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const FittedSurfel& leaf = leaves[piece][i];
                if ((rules.owns && !rules.owns(leaf.surfel.center)) ||
                    removal.center_needs(leaf.surfel, centers[before + i]))
                    continue;
                std::vector<LeafShare> shares = removal.shares_of(leaf, balls.local());
                const auto worse = removal.worse_without(leaf.surfel, shares);
                if (!worse) continue;
                found[i] = {piece, i, before + i, leaf.point_id, *worse, std::move(shares), {}};
            }
        });
        for (std::optional<Needless>& f : found)
            if (f) out.push_back(std::move(*f));
    }
    std::sort(out.begin(), out.end(), [](const Needless& a, const Needless& b) {
        return std::tie(a.worse, a.id) < std::tie(b.worse, b.id);
    });
    return out;
}

/// Fills the neighbours of the candidates, of leaves that may be relied on.
void find_neighbours(std::vector<Needless>& candidates, const NeedlessRules& rules,
                     const Pieces& leaves) {
    Leaves stay;
    for (const std::vector<FittedSurfel>& piece : leaves)
        for (const FittedSurfel& leaf : piece)
            if (!rules.owns || rules.owns(leaf.surfel.center)) stay.push_back(&leaf.surfel);
    std::vector<Needless*> some;
    for (Needless& c : candidates) some.push_back(&c);
    const auto along = leaves_along_curve(some, [&](const Needless& c) -> const Surfel& {
        return leaves[c.piece][c.index].surfel;
    });
    if (along.empty()) return;
    Leaves surfels;
    for (const Needless* c : along) surfels.push_back(&leaves[c->piece][c->index].surfel);
    for_leaves_together(surfels, LeafBalls(stay),
                        [&](std::size_t first, std::span<const Surfel* const> together,
                            const LeafBalls& near) {
                            for (std::size_t k = 0; k < together.size(); ++k)
                                append_meeting(*together[k], near, along[first + k]->near);
                        });
}

}  // namespace

bool may_be_needless(const CoverRules& rules, double spacing) {
    // of clouds that are fitted again clean ones have up to 0.056 (julius_original, iron_scan), a
    // cylinder with noise 5e-4 L 0.085
    constexpr double kNoisy = 0.07;  // sqrt(lambda) of a typical place over the spacing
    return rules.fits_again() && rules.typical_variance <= kNoisy * kNoisy * spacing * spacing;
}

NeedlessRules needless_rules(const CoverRules& rules, double spacing) {
    // E is of a unit of area, of which the points have spacing^2 each; its price times rho^2, about
    // what a leaf has to itself, is the same for all leaves.
    const double price = rules.energy().price(spacing);
    return {rules.noise_variance, kPriceShare * price, rules.farthest(), rules.owns};
}

void remove_needless(const PointTree& points, const NeedlessRules& rules,
                     std::span<const std::uint32_t> centers, std::span<BlendResidual> blend,
                     std::span<std::uint8_t> n_drawn,
                     std::vector<std::vector<FittedSurfel>>& leaves, const NumberedVisit& removed) {
    Removal removal(points, rules, blend, n_drawn);
    std::vector<std::vector<bool>> gone(leaves.size());
    for (std::size_t piece = 0; piece < leaves.size(); ++piece)
        gone[piece].resize(leaves[piece].size());
    std::vector<Needless> candidates = candidates_of(removal, rules, leaves, centers);
    find_neighbours(candidates, rules, leaves);
    Drawn drawn;
    // Each is asked again: what went before it is missing now.
    for (const Needless& c : candidates) {
        const FittedSurfel& leaf = leaves[c.piece][c.index];
        if (!removal.worse_without(leaf.surfel, c.shares) ||
            !drawn.is_drawn_by_others(leaf.surfel, c.near))
            continue;
        removal.remove(c.shares);
        drawn.remove(leaf.surfel);
        removed(leaf, c.number);
        gone[c.piece][c.index] = true;
    }
    for (std::size_t piece = 0; piece < leaves.size(); ++piece) {
        std::size_t n_left = 0;
        for (std::size_t i = 0; i < leaves[piece].size(); ++i)
            if (!gone[piece][i]) leaves[piece][n_left++] = leaves[piece][i];
        leaves[piece].resize(n_left);
    }
}

}  // namespace slim
