#include "slim/cover/level_cover.h"

#include "slim/base/parallel.h"
#include "slim/cover/batch_places.h"
#include "slim/cover/leaf_rim.h"
#include "slim/cover/level_cover_run.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

namespace slim {
namespace {

/// Centres far from the leaves so far come first: passes of a level, by the most overlap a centre
/// may have. In one pass, of random order, many leaves stand just outside another's reach and cover
/// little that is new (leaves of igea at T 0.02, bunny_raw and happy_stand_raw at 0.01: 6,458,
/// 5,837, 19,081 against 5,956, 5,399, 18,068 at the same errors; seven passes win no more).
constexpr float kCrowding[] = {0.008f, 0.025f, 0.06f, static_cast<float>(kCoverage)};
constexpr std::size_t kBatch = 256;         // most searches between two rounds of acceptance
constexpr std::size_t kMostUndecided = 288;  // centres, searched or held
constexpr std::size_t kPrefetch = 32;       // centres whose state and place are fetched ahead
constexpr std::size_t kLeastTogether = 8192;  // waiting points that all threads look through,
constexpr std::size_t kParts = 24;            // and of how many parts these are one
constexpr std::size_t kLeastGain = 8;       // searches of a batch for one centre that is held
constexpr double kConflict = 0.5;           // share of rho_r within which a
                                            // centre likely forestalls another
constexpr double kWantedInBall = 240;       // points of a thinning in a ball of the level

/// Those of some points that are wanted. Their states lie anywhere in memory, and are fetched
/// ahead.
template <class IsWanted>
std::vector<std::uint32_t> wanted_of(std::span<const std::uint32_t> points,
                                     const CoverStates& states, const IsWanted& is_wanted) {
    constexpr std::size_t kGrain = 2048;
    std::vector<std::vector<std::uint32_t>> parts((points.size() + kGrain - 1) / kGrain);
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> part;
        for (std::size_t i = begin; i < end; ++i) {
            states.prefetch(points[std::min(i + kPrefetch, end - 1)]);
            if (is_wanted(points[i])) part.push_back(points[i]);
        }
        parts[begin / kGrain] = std::move(part);
    });
    std::vector<std::uint32_t> out;
    for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
    return out;
}

}  // namespace

LevelCover::LevelCover(const PointBlock& points, const CoverRules& rules,
                       const PointPyramid& pyramid)
    : block_(points),
      rules_(rules),
      pyramid_(pyramid),
      leaves_(points, rules, pyramid_),
      states_(points, rules),
      second_(rules.fits_again() ? points.size() : 0,
              may_be_needless(rules, leaves_.spacing())),
      open_(points.size()),
      n_open_(points.size()),
      work_([&rules] {
          LeafWork w;
          w.ladder.ball.weight = w.exact.ball.weight = rules.weight;
          w.ladder.ball.normals_count = w.exact.ball.normals_count = rules.follow_normals;
          return w;
      }) {
    std::iota(open_.begin(), open_.end(), 0u);
}

Cover LevelCover::run(Reporter& reporter) {
    if (rules_.done) mark_done();
    const std::size_t n = block_.size();
    for (int level = rules_.first_level; level <= rules_.last_level; ++level) {
        const std::size_t thinning = thinning_for(level_radius(rules_.diagonal, level));
        const bool some_are_open = sift_open(thinning);
        reporter.progress("fit", some_are_open ? n - n_open_ : n, n);
        if (!some_are_open) break;
        run_level(level, thinning);
        out_.counts.levels = static_cast<std::uint64_t>(level);
    }
    aside_.wait();
    out_.counts += of_leaves_;
    reporter.progress("fit", n - states_.count_open(), n);
    if (rules_.fits_again() || closes_gaps()) finish_leaves();
    for (const LeafWork& w : work_) {
        out_.counts.rungs += w.ladder.rungs;
        out_.counts.sharp_rungs += w.ladder.sharp_rungs;
        out_.counts.refinements += w.ladder.refinements;
        out_.counts.point_visits += w.ladder.point_visits;
        out_.counts.evaluated += w.searches;
    }
    return std::move(out_);
}

/// The coarsest thinning that still has enough points in a usual ball of this radius.
std::size_t LevelCover::thinning_for(double radius) const {
    const double spacing = leaves_.spacing();
    if (!(spacing > 0)) return 0;
    const double n_in_ball = std::numbers::pi * radius * radius / (spacing * spacing);
    std::size_t t = pyramid_.n_levels() - 1;
    while (t > 0 && n_in_ball * pyramid_.share(t) < kWantedInBall) --t;
    return t;
}

bool LevelCover::is_closed(std::uint32_t rank) const {
    return !states_.is_open(pyramid_.by_priority()[rank]);
}

/// Whether points are open. Only all of them are sifted for good and counted: the coarse levels
/// look at few, which a pass over all would cost more than.
bool LevelCover::sift_open(std::size_t thinning) {
    if (thinning > 0) return states_.has_open();
    parallel_erase_if(open_, [&](std::uint32_t rank) { return is_closed(rank); });
    n_open_ = open_.size();
    return n_open_ > 0;
}

void LevelCover::run_level(int level, std::size_t thinning) {
    const auto end = std::lower_bound(open_.begin(), open_.end(), pyramid_.level_size(thinning));
    std::vector<std::uint32_t> waiting(open_.begin(), end);
    if (thinning > 0)
        parallel_erase_if(waiting, [&](std::uint32_t rank) { return is_closed(rank); });
    for (std::uint32_t& rank : waiting) rank = pyramid_.by_priority()[rank];
    for (const float most_overlap : kCrowding) {
        run_pass(level, thinning, std::min(most_overlap, rules_.coverage()), waiting);
    }
}

/// Searches and accepts centres among the waiting points of a level whose overlap is not above a
/// limit. A point that lies in no core is open whatever its overlap: the last pass takes them all.
/// What is closed or crowded once stays so: all threads pass it over part by part.
void LevelCover::run_pass(int level, std::size_t thinning, float most_overlap,
                          const std::vector<std::uint32_t>& waiting) {
    const bool last = most_overlap >= rules_.coverage();
    const auto may_lead = [&](std::uint32_t p) { return states_.may_lead(p, level); };
    const auto is_free = [&](std::uint32_t p) { return last || states_.weight(p) <= most_overlap; };
    const auto is_wanted = [&](std::uint32_t p) { return may_lead(p) && is_free(p); };
    const std::size_t n_together = std::max(kLeastTogether, waiting.size() / kParts);
    std::vector<std::uint32_t> ready;
    std::size_t next = 0, n_taken = 0;  // of `ready`, of `waiting`

    std::vector<CoverCandidate> batch;
    while (true) {
        if (next == ready.size() && n_taken < waiting.size()) {
            const std::size_t n = std::min(n_together, waiting.size() - n_taken);
            ready = wanted_of(std::span(waiting).subspan(n_taken, n), states_, is_wanted);
            n_taken += n, next = 0;
        }
        if (next == ready.size() && batch.empty()) {
            if (n_taken == waiting.size()) break;
            continue;
        }
        next = fill_batch(ready, next, level, is_wanted, batch);
        parallel_blocks(batch.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (batch[i].stage != SearchStage::next) continue;
                search(batch[i], level, thinning);
                batch[i].stage = SearchStage::done;
            }
        });
        settle_aside(batch, decide(batch, level, is_wanted));
    }
}

/// Accepts the first of a batch that are searched, up to one that is not and is still wanted, and
/// returns how many are decided then. Isolated ones are neither leaves nor internal, and forestall
/// nothing.
template <class IsWanted>
std::size_t LevelCover::decide(std::vector<CoverCandidate>& batch, int level,
                               const IsWanted& is_wanted) {
    std::size_t n = 0;
    for (; n < batch.size(); ++n) {
        CoverCandidate& c = batch[n];
        const bool is_searched = c.stage == SearchStage::done;
        if (!is_wanted(c.point)) {
            out_.counts.discarded += is_searched;
            continue;
        }
        if (!is_searched) break;
        accept(c, level);
        if (!c.choice.isolated) forestalling_.add(c.leaf);
    }
    return n;
}

/// Adds the next wanted centres to those of a batch that are not decided yet, and says which are
/// searched. Returns how many of `ready` are taken then. A centre near one before it, which
/// likely forestalls it, is held until that one is decided.
template <class IsWanted>
std::size_t LevelCover::fill_batch(const std::vector<std::uint32_t>& ready, std::size_t next,
                                   int level, const IsWanted& is_wanted,
                                   std::vector<CoverCandidate>& batch) const {
    // an internal surfel forestalls all centres in its ball, a leaf those near its own
    const double conflict = forestalling_.are_often_internal() ? 1 : kConflict;
    BatchPlaces places(conflict * level_radius(rules_.diagonal, level));
    std::size_t n_next = 0, n_held = 0;
    const auto take = [&](CoverCandidate& c) {
        const bool is_free = places.add(block_.position[c.point]);
        if (c.stage == SearchStage::done) return;
        c.stage = is_free ? SearchStage::next : SearchStage::held;
        ++(is_free ? n_next : n_held);
    };
    for (CoverCandidate& c : batch) take(c);
    const auto is_enough = [&] {
        return n_next >= kBatch || batch.size() >= kMostUndecided || n_held * kLeastGain > n_next;
    };
    for (; next < ready.size() && !is_enough(); ++next) {
        const std::uint32_t ahead = ready[std::min(next + kPrefetch, ready.size() - 1)];
        states_.prefetch(ahead);
        __builtin_prefetch(&block_.position[ahead]);
        if (!is_wanted(ready[next])) continue;
        batch.emplace_back().point = ready[next];
        take(batch.back());
    }
    return next;
}

/// Has the decided ones settled, the first n of a batch, while the rest goes on.
void LevelCover::settle_aside(std::vector<CoverCandidate>& batch, std::size_t n) {
    aside_.wait();
    const auto end = batch.begin() + static_cast<std::ptrdiff_t>(n);
    settled_.assign(std::move_iterator(batch.begin()), std::move_iterator(end));
    batch.erase(batch.begin(), end);
    aside_.run([this] { settle(settled_); });
}

/// What the next batch does not wait for: sums of what the leaves of a batch leave over, counts,
/// memory given back.
void LevelCover::settle(std::vector<CoverCandidate>& batch) {
    for (const CoverCandidate& c : batch) {
        if (c.is_accepted && rules_.fits_again())
            second_.blend(c.surfel, owns(c.surfel.fitted.surfel.center));
        if (c.is_kept) of_leaves_.add_leaf(c.surfel);
    }
    batch.clear();
}

void LevelCover::search(CoverCandidate& c, int level, std::size_t thinning) {
    LeafWork& work = work_.local();
    c.center = c.point;
    c.level = level;
    if (!states_.recall(c)) leaves_.choose(c, work);
    const double lower = level_radius(rules_.diagonal, level) * kGoldenRatio * kGoldenRatio;
    c.leaf = c.choice.radius >= lower && !c.choice.isolated;
    if (c.choice.isolated) return;
    // Known without a fit: many points of rims end here.
    c.few_in_noise = c.leaf && c.choice.forced && is_raw() && leaves_.is_few_in_noise(c);
    if (c.few_in_noise && states_.is_beside(c.point)) return;
    if (c.leaf) leaves_.make(c, lower, work);
    if (c.leaf && c.surfel.explains_center) c.surfel.fitted.surfel.rims = rims_of(c.surfel);
    if (!c.leaf && !c.choice.isolated)
        make_internal(c, level_radius(rules_.diagonal, level), thinning, work);
}

void LevelCover::make_internal(CoverCandidate& c, double radius, std::size_t thinning,
                               LeafWork& work) const {
    const Vec3d center = block_.position[c.point];
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    const PointTree& tree = pyramid_.level(thinning);
    c.internal = fit_surfel(tree, center, normal, radius, rules_.usual_degree(), false,
                            rules_.noise_variance, work.exact.ball, Edges::ignored, Lists::left_out)
                     .fitted;
    for (std::size_t i = 0; i < work.exact.ball.n; ++i)
        c.stamped.push_back(tree.source(work.exact.ball.index[i]));
}

}  // namespace slim
