#include "slim/cover/cover_states.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <atomic>

namespace slim {

namespace {

constexpr std::size_t kAhead = 24;  // points whose state is fetched while those before are marked

}  // namespace

CoverStates::CoverStates(const PointBlock& points, const CoverRules& rules)
    : block_(points),
      rules_(rules),
      states_(points.size()),
      radius_(points.size(), 0.0f),
      finest_(points.size(), 0.0f) {
    if (rules.dropped.empty()) return;
    std::vector<std::uint64_t> dropped(rules.dropped.begin(), rules.dropped.end());
    std::sort(dropped.begin(), dropped.end());
    parallel_blocks(points.size(), 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (std::binary_search(dropped.begin(), dropped.end(), points.id[i]))
                states_[i].flags = kClosed;
    });
}

std::size_t CoverStates::count_open() const {
    std::atomic<std::size_t> n = 0;
    parallel_blocks(states_.size(), 65536, [&](std::size_t begin, std::size_t end) {
        std::size_t own = 0;
        for (std::size_t p = begin; p < end; ++p)
            own += is_open(static_cast<std::uint32_t>(p)) ? 1u : 0u;
        n += own;
    });
    return n;
}

bool CoverStates::has_open() const {
    std::atomic<bool> any = false;
    parallel_blocks(states_.size(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end && !any; ++p)
            if (is_open(static_cast<std::uint32_t>(p))) any = true;
    });
    return any;
}

bool CoverStates::recall(LeafCandidate& c) const {
    if (!(radius_[c.point] > 0)) return false;
    const PointState& s = states_[c.point];
    c.choice = {radius_[c.point],
                s.degree,
                (s.flags & kSaturatedTop) != 0,
                (s.flags & kForced) != 0,
                false,
                (s.flags & kLimited) != 0,
                0,
                finest_[c.point],
                (s.flags & kWidened) != 0};
    c.sparse = (s.flags & kThin) != 0;
    c.n_sheets = s.further_sheets + 1u;
    return true;
}

void CoverStates::remember(const LeafCandidate& c) {
    radius_[c.point] = static_cast<float>(c.choice.radius);
    finest_[c.point] = static_cast<float>(c.choice.finest);
    PointState& s = states_[c.point];
    s.degree = static_cast<std::uint8_t>(c.choice.degree & 7);
    if (c.choice.forced) s.flags |= kForced;
    // a smaller radius is neither
    s.flags = static_cast<std::uint16_t>(s.flags & ~(kSaturatedTop | kWidened));
    if (c.choice.saturated) s.flags |= kSaturatedTop;
    if (c.choice.limited) s.flags |= kLimited;
    if (c.choice.widened) s.flags |= kWidened;
    if (c.sparse) s.flags |= kThin;
    s.further_sheets = static_cast<std::uint8_t>((c.n_sheets - 1) & 31);
}

/// How often a leaf counts in the overlap.
float CoverStates::times(const FittedSurfel& leaf) const {
    if ((leaf.flags & (slim::kForced | slim::kLimited)) == 0) return 1;
    const double price = rules_.energy().price(leaf.surfel.support_radius);
    return rules_.refits ? limited_times(price, leaf.fit_error * leaf.fit_error) : kLimitedTimes;
}

void CoverStates::mark(const CoveringSurfel& leaf, bool is_steady) {
    const float n_times = times(leaf.fitted);
    const Surfel& surfel = leaf.fitted.surfel;
    const double sq_radius = surfel.support_radius * surfel.support_radius;
    const auto overlap = [&](const Covered& p) {
        if (rules_.reading == CoverReading::b) return p.weight;
        const double sq = sq_length(block_.position[p.point] - surfel.center) / sq_radius;
        return overlap_weight(rules_.reading, static_cast<float>(sq));
    };
    const std::uint16_t beside = is_steady ? kBeside : 0;
    for (std::size_t i = 0; i < leaf.covered.size(); ++i) {
        if (i + kAhead < leaf.covered.size()) prefetch(leaf.covered[i + kAhead].point);
        const Covered& p = leaf.covered[i];
        PointState& state = states_[p.point];
        state.weight += n_times * overlap(p);
        state.flags |= static_cast<std::uint16_t>(beside | (p.in_core ? kCore : 0));
    }
    if (!is_steady) return;
    for (const std::uint32_t p : leaf.beside) states_[p].flags |= kBeside;
}

}  // namespace slim
