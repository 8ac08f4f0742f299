#include "slim/cover/own_leaves.h"

#include "slim/cover/drawn_part.h"
#include "slim/cover/far_points.h"
#include "slim/cover/gaps.h"
#include "slim/cover/sound_normal.h"
#include "slim/model/surfel_encoder.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace slim {
namespace {

constexpr int kRounds = 6;
constexpr int kTries = 2;       // of a point
constexpr double kApart = 0.5;  // over rho: a leaf of the same round may have mended it
constexpr double kThin = 0.1;   // eps / rho: a thicker leaf is no surface to close a gap with

bool is_thin(const FittedSurfel& f) { return f.fit_error <= kThin * f.surfel.support_radius; }

class OwnLeaves {
public:
    OwnLeaves(const PointTree& points, const PointBlock& block, const CoverRules& rules,
              const LeafMaker& maker, const SurfelSource& others,
              std::span<const std::uint64_t> strays, LeafWork& work)
        : points_(points),
          block_(block),
          rules_(rules),
          maker_(maker),
          work_(work),
          mended_in_(points.size(), 0),
          dropped_(rules.dropped.begin(), rules.dropped.end()) {
        dropped_.insert(strays.begin(), strays.end());
        if (rules.done)
            rules.done([&](const FittedSurfel& f) {
                if (f.flags & kLeaf)
                    leaves_.push_back(&copies_.emplace_back(level_linear(f.surfel)));
            });
        others([&](const FittedSurfel& f) { blend(f.surfel); });
    }

    std::deque<CoveringSurfel> take() { return std::move(own_); }

    /// Gives gaps between the leaves a leaf each, of a point beside it: that of its finest ball if
    /// that closes the gap, else what its search finds. Returns how many.
    std::size_t close_gaps(std::span<const std::uint64_t> given_up) {
        std::unordered_set<std::uint64_t> nobodys(given_up.begin(), given_up.end());
        nobodys.insert(dropped_.begin(), dropped_.end());
        for (const Gap& gap : find_gaps(points_, leaves_)) {
            const std::uint32_t point = points_.source(gap.point);
            if (!owns(gap.point) || nobodys.contains(block_.id[point])) continue;
            const auto closes = [&](const CoveringSurfel& leaf) {
                return is_drawn_at(leaf.fitted.surfel, gap.place, gap.normal);
            };
            const std::uint64_t id = block_.id[point];
            const auto serves = [&](const std::optional<CoveringSurfel>& leaf) {
                return leaf && leaf->fitted.point_id == id && closes(*leaf) &&
                       is_thin(leaf->fitted) && !maker_.rounds_off(*leaf);
            };
            if (std::any_of(own_.begin(), own_.end(), closes)) continue;
            if (!nobodys.insert(id).second) continue;  // no two leaves of a point
            auto leaf = maker_.make_own(point, 0, work_);
            if (!serves(leaf)) leaf = maker_.make_usual(point, work_);
            if (serves(leaf)) add(std::move(*leaf));
        }
        return own_.size();
    }

    void mend_far_points() {
        std::vector<std::uint32_t> places = first_places();
        for (int round = 0; round < kRounds && !places.empty(); ++round) {
            auto far = far_points(points_, places, leaves_, rules_.farthest(),
                                  has_stray_normals(rules_));
            std::stable_sort(far.begin(), far.end(),
                             [](const auto& a, const auto& b) { return a.off > b.off; });
            places = mend(far, static_cast<std::uint8_t>(round + 1));
        }
    }

private:
    /// Adds a leaf as the file will hold it, which turns the axes of linear ones, and so their rims
    /// a little.
    void blend(const Surfel& s) {
        leaves_.push_back(s.degree < 2 ? &copies_.emplace_back(level_linear(s)) : &s);
    }

    bool owns(std::uint32_t place) const {
        return !rules_.owns || rules_.owns(points_.position(place));
    }

    std::vector<std::uint32_t> first_places() const {
        std::vector<std::uint32_t> out = maybe_far(points_, leaves_, rules_.farthest());
        std::erase_if(out, [&](std::uint32_t i) { return !owns(i); });
        return out;
    }

    /// Gives points their leaves; returns the places to look at again, rising. round: from 1 on
    std::vector<std::uint32_t> mend(const std::vector<FarPoint>& far, std::uint8_t round) {
        std::vector<std::uint32_t> again;
        const BallPoints<double>& ball = work_.exact.ball;
        for (const FarPoint& p : far) {
            if (mended_in_[p.place] == round)
                again.push_back(p.place);
            else if (add_leaf(p.place))
                for (std::size_t i = 0; i < ball.n; ++i) {
                    if (ball.sq[i] < kApart * kApart) mended_in_[ball.index[i]] = round;
                    if (owns(ball.index[i])) again.push_back(ball.index[i]);
                }
        }
        std::sort(again.begin(), again.end());
        again.erase(std::unique(again.begin(), again.end()), again.end());
        return again;
    }
    /// Gives a point its leaf, whose ball is left in the workspace.
    bool add_leaf(std::uint32_t place) {
        const std::uint32_t point = points_.source(place);
        Tries& tries = tries_[place];
        if (tries.made == kTries || dropped_.contains(block_.id[point])) return false;
        ++tries.made;
        auto leaf = maker_.make_own(point, tries.leaves, work_);
        if (!leaf) return false;
        ++tries.leaves;
        leaf->fitted.flags = kForced;
        add(std::move(*leaf));
        const Surfel& s = *leaves_.back();
        gather_ball(points_, s.center, s.support_radius, work_.exact.ball);
        return true;
    }
    void add(CoveringSurfel&& leaf) {
        FittedSurfel& f = own_.emplace_back(std::move(leaf)).fitted;
        f.flags |= kLeaf;
        f.level = static_cast<std::uint8_t>(level_of(f.surfel.support_radius, rules_.diagonal,
                                                     rules_.first_level, rules_.last_level));
        leaves_.push_back(&f.surfel);
    }

    const PointTree& points_;
    const PointBlock& block_;
    const CoverRules& rules_;
    const LeafMaker& maker_;
    std::vector<const Surfel*> leaves_;
    LeafWork& work_;
    std::deque<CoveringSurfel> own_;  // whose surfels leaves_ refers to, as to
    std::deque<Surfel> copies_;       // these
    struct Tries {
        int made = 0, leaves = 0;
    };
    std::unordered_map<std::uint32_t, Tries> tries_;  // of places
    // the last round in which a leaf came near a place
    std::vector<std::uint8_t> mended_in_;
    std::unordered_set<std::uint64_t> dropped_;
};

}  // namespace

OwnLeavesFound own_leaves(const PointTree& points, const PointBlock& block,
                          const CoverRules& rules, const LeafMaker& maker,
                          const SurfelSource& others, const OwnLeafRules& own, LeafWork& work) {
    OwnLeaves leaves(points, block, rules, maker, others, own.strays, work);
    OwnLeavesFound out;
    if (own.at_gaps) out.n_at_gaps = leaves.close_gaps(own.dropped);
    if (rules.fits_again()) leaves.mend_far_points();
    out.leaves = leaves.take();
    return out;
}

}  // namespace slim
