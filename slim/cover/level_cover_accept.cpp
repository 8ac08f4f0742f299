// What a run over levels takes up: leaves of levels before, what its searches found, and what is
// left once all leaves are known.

#include "slim/base/parallel.h"
#include "slim/cover/level_cover_run.h"
#include "slim/cover/own_leaves.h"
#include "slim/cover/scatter.h"
#include "slim/model/surfel_tree.h"

#include <span>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kMarkedAtOnce = 8;    // leaves of levels before whose points
                                            // are listed at the same time
constexpr std::size_t kMarkedShare = 8;     // of the points held, one in so many:
                                            // lists take 24 bytes a point

}  // namespace

bool LevelCover::is_kept(const FittedSurfel& f) const {
    const bool is_provisional = f.level == rules_.last_level &&
                                f.surfel.support_radius <= rules_.provisional;
    return !is_provisional && owns(f.surfel.center);
}

void LevelCover::keep(const FittedSurfel& f) {
    if (rules_.keep)
        rules_.keep(f);
    else
        out_.surfels.push_back(f);
}

/// Marks the leaves of the levels before. Their sums are taken one after the other,
/// whatever finds their points.
void LevelCover::mark_done() {
    std::vector<FittedSurfel> some;
    std::size_t n_points = 0;  // that they cover, in all slices
    rules_.done([&](const FittedSurfel& s) {
        if (!(s.flags & kLeaf)) return;
        some.push_back(s);
        n_points += s.n_points;
        if (some.size() < kMarkedAtOnce && kMarkedShare * n_points < block_.size()) return;
        mark_again(some);
        some.clear();
        n_points = 0;
    });
    mark_again(some);
}

/// Nobody asks what else lies over a point that is closed, unless leaves are fitted to what their
/// blend leaves over.
void LevelCover::mark_again(std::span<const FittedSurfel> leaves) {
    WantedOfBucket open;
    if (!rules_.fits_again())
        open = [&](std::size_t first) { return states_.open_of_bucket(pyramid_.all(), first); };
    std::vector<CoveringSurfel> covering(leaves.size());
    parallel_blocks(leaves.size(), 1, [&](std::size_t i, std::size_t) {
        covering[i] = cover_again(pyramid_.all(), leaves[i], rules_.noise_variance,
                                  work_.local().exact.ball, open);
    });
    for (const CoveringSurfel& leaf : covering) {
        mark(leaf);
        if (rules_.fits_again()) second_.blend(leaf, true);
    }
}

void LevelCover::accept(CoverCandidate& c, int level) {
    states_.remember(c);
    if (c.choice.isolated) {
        strays_.push_back(block_.id[c.point]);
        out_.counts.isolated += drop(c.point);
        return;
    }
    if (!c.leaf) {
        c.internal.level = static_cast<std::uint8_t>(level);
        c.internal.point_id = block_.id[c.point];
        if (is_kept(c.internal)) {
            keep(c.internal);
            ++out_.counts.internals;
        }
        for (const std::uint32_t p : c.stamped) states_.stamp(p, level);
        states_.stamp(c.point, level);
        return;
    }
    accept_leaf(c, level);
}

void LevelCover::accept_leaf(CoverCandidate& c, int level) {
    if (c.few_in_noise && states_.is_beside(c.point)) {
        out_.counts.beside += drop(c.point);
        return;
    }
    if (!c.surfel.explains_center) {
        out_.counts.unexplained += drop(c.point);
        return;
    }
    FittedSurfel& f = c.surfel.fitted;
    f.level = static_cast<std::uint8_t>(level);
    // The largest radius of fine levels is that of the halo: reaching it says nothing of E.
    const bool saturated = c.choice.saturated && rules_.first_level == 1;
    f.flags = static_cast<std::uint8_t>(kLeaf | (saturated ? kSaturated : 0) |
                                        (c.choice.forced ? kForced : 0) |
                                        (c.choice.limited ? kLimited : 0));
    f.point_id = block_.id[c.center];
    if (is_raw() && states_.is_beside(c.point) && is_doubtful(f, rules_.noise_variance)) {
        out_.counts.beside += drop(c.point);
        return;
    }
    states_.close(c.point);
    mark(c.surfel);
    c.is_accepted = true;
    if (rules_.fits_again()) second_.wait(c.surfel, c.center);
    else if (closes_gaps())
        known_.push_back(f);
    if (!is_kept(f)) return;
    c.is_kept = true;
    out_.counts.recentred += c.center != c.point;
    out_.counts.contrary += c.choice.limited;
    if (!rules_.fits_again()) keep(f);
}

/// Once all leaves are known. Those of coarse levels, of whose points a slice sees a part only,
/// stay as they are.
void LevelCover::finish_leaves() {
    if (second_.removes())
        second_.remove(pyramid_.all(), needless_rules(rules_, leaves_.spacing()),
                       [&](const FittedSurfel& leaf, const LeafCount& count) {
                           if (is_kept(leaf)) out_.counts.take_back(leaf, count);
                       });
    out_.counts.refitted += second_.run(pyramid_.all());
    const auto own = own_leaves(
        pyramid_.all(), block_, rules_, leaves_,
        [&](const SurfelVisit& visit) { for_known_leaves(visit); },
        {strays_, out_.dropped, closes_gaps()}, work_.local());
    second_.hand_over([&](const FittedSurfel& leaf) {
        if (is_kept(leaf)) keep(leaf);
    });
    for (std::size_t i = 0; i < own.leaves.size(); ++i) {
        const CoveringSurfel& leaf = own.leaves[i];
        if (!is_kept(leaf.fitted)) continue;
        ++(i < own.n_at_gaps ? out_.counts.gaps : out_.counts.own);
        out_.counts.add_leaf(leaf);
        keep(leaf.fitted);
    }
}

/// Of this job, as they end.
void LevelCover::for_known_leaves(const SurfelVisit& visit) const {
    if (rules_.fits_again()) return second_.for_each(visit);
    for (const FittedSurfel& f : known_) visit(f);
}

/// Leaves a point to nobody; whether it counts here. A sample's is looked at again with all its
/// neighbours.
bool LevelCover::drop(std::uint32_t point) {
    states_.close(point);
    if (rules_.is_sample() || !owns(block_.position[point])) return false;
    out_.dropped.push_back(block_.id[point]);
    return true;
}

void LevelCover::mark(const CoveringSurfel& leaf) {
    states_.mark(leaf, is_raw() && !is_doubtful(leaf.fitted, rules_.noise_variance));
}

}  // namespace slim
