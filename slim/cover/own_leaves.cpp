#include "slim/cover/own_leaves.h"

#include "slim/cover/far_points.h"
#include "slim/model/surfel_encoder.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace slim {
namespace {

constexpr int kRounds = 6;
constexpr int kTries = 2;       // leaves of a point
constexpr double kApart = 0.5;  // over rho: a leaf of the same round may have mended what is so near

class OwnLeaves {
public:
    OwnLeaves(const PointTree& points, const PointBlock& block, const CoverRules& rules, const LeafMaker& maker,
              const SecondFit& others, std::span<const std::uint64_t> strays, LeafWork& work)
        : points_(points), block_(block), rules_(rules), maker_(maker), work_(work),
          dropped_(rules.dropped.begin(), rules.dropped.end()) {
        dropped_.insert(strays.begin(), strays.end());
        if (rules.done)
            rules.done([&](const FittedSurfel& f) {
                if (f.flags & kLeaf) blend(copies_.emplace_back(f.surfel));
            });
        others.for_each([&](const FittedSurfel& f) { blend(f.surfel); });
    }

    std::deque<CoveringSurfel> run() {
        std::vector<std::uint32_t> places = first_places();
        for (int round = 0; round < kRounds && !places.empty(); ++round) {
            auto far = far_points(points_, places, leaves_, rules_.farthest());
            std::stable_sort(far.begin(), far.end(), [](const auto& a, const auto& b) { return a.off > b.off; });
            places = mend(far);
        }
        return std::move(own_);
    }

private:
    /// Adds a leaf as the file will hold it, which turns the axes of linear ones, and so their rims a little.
    void blend(const Surfel& s) { leaves_.push_back(s.degree < 2 ? &copies_.emplace_back(level_linear(s)) : &s); }

    std::vector<std::uint32_t> first_places() const {
        std::vector<std::uint32_t> out = maybe_far(points_, leaves_, rules_.farthest());
        if (rules_.owns) std::erase_if(out, [&](std::uint32_t i) { return !rules_.owns(points_.position(i)); });
        return out;
    }

    /// Gives points their leaves; returns the places to look at again, rising.
    std::vector<std::uint32_t> mend(const std::vector<FarPoint>& far) {
        std::vector<std::uint32_t> again;
        const std::size_t n_before = own_.size();
        for (const FarPoint& p : far) {
            if (is_near_one(points_.position(p.place), n_before))
                again.push_back(p.place);
            else if (add_leaf(p.place))
                again.insert(again.end(), work_.exact.ball.index.begin(),
                             work_.exact.ball.index.begin() + static_cast<std::ptrdiff_t>(work_.exact.ball.n));
        }
        std::sort(again.begin(), again.end());
        again.erase(std::unique(again.begin(), again.end()), again.end());
        return again;
    }
    /// Whether one of the leaves from number `first` on is near.
    bool is_near_one(const Vec3d& p, std::size_t first) const {
        return std::any_of(own_.begin() + static_cast<std::ptrdiff_t>(first), own_.end(), [&](const CoveringSurfel& leaf) {
            const double reach = kApart * leaf.fitted.surfel.support_radius;
            return sq_length(p - leaf.fitted.surfel.center) < reach * reach;
        });
    }
    /// Gives a point its leaf, whose ball is left in the workspace.
    bool add_leaf(std::uint32_t place) {
        const std::uint32_t point = points_.source(place);
        int& n_tries = n_tries_[place];
        if (n_tries == kTries || dropped_.contains(block_.id[point])) return false;
        auto leaf = maker_.make_own(point, n_tries++, work_);
        if (!leaf) return false;
        FittedSurfel& f = own_.emplace_back(std::move(*leaf)).fitted;
        const Surfel& s = f.surfel;
        f.flags = kLeaf | kForced;
        f.level = static_cast<std::uint8_t>(
            level_of(s.support_radius, rules_.diagonal, rules_.first_level, rules_.last_level));
        leaves_.push_back(&s);
        gather_ball(points_, s.center, s.support_radius, work_.exact.ball);
        return true;
    }

    const PointTree& points_;
    const PointBlock& block_;
    const CoverRules& rules_;
    const LeafMaker& maker_;
    std::vector<const Surfel*> leaves_;
    LeafWork& work_;
    std::deque<CoveringSurfel> own_;  // whose surfels leaves_ refers to, as to
    std::deque<Surfel> copies_;       // these
    std::unordered_map<std::uint32_t, int> n_tries_;
    std::unordered_set<std::uint64_t> dropped_;
};

}  // namespace

std::deque<CoveringSurfel> own_leaves(const PointTree& points, const PointBlock& block, const CoverRules& rules,
                                      const LeafMaker& maker, const SecondFit& others, std::span<const std::uint64_t> strays,
                                      LeafWork& work) {
    return OwnLeaves(points, block, rules, maker, others, strays, work).run();
}

}  // namespace slim
