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

namespace slim {
namespace {

/// Centres far from the leaves so far come first: passes of a level, by the most overlap a centre
/// may have. In one pass, of random order, many leaves stand just outside another's reach and cover
/// little that is new (leaves of igea at T 0.02, bunny_raw and happy_stand_raw at 0.01: 6,458,
/// 5,837, 19,081 against 5,956, 5,399, 18,068 at the same errors; seven passes win no more).
constexpr float kCrowding[] = {0.008f, 0.025f, 0.06f, static_cast<float>(kCoverage)};
constexpr std::size_t kBatch = 256;         // most searches between two rounds of acceptance
constexpr std::size_t kLeastGain = 8;       // searches of a batch for one that is likely in vain
constexpr std::size_t kPrefetch = 32;       // centres whose state is fetched ahead
constexpr double kConflict = 0.5;           // share of rho_r within which a
                                            // centre likely forestalls another
constexpr double kWantedInBall = 240;       // points of a thinning in a ball of the level

/// The box of points.
Bbox box_of(const PointBlock& points) {
    constexpr std::size_t kGrain = 65536;
    std::vector<Bbox> parts((points.size() + kGrain - 1) / kGrain);
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Bbox box;
        for (std::size_t i = begin; i < end; ++i) box.extend(points.position[i]);
        parts[begin / kGrain] = box;
    });
    Bbox box;
    for (const Bbox& part : parts) box.extend(part);
    return box;
}

EdgeQuestion edge_question(const CoverRules& rules, std::size_t n_here) {
    const double n = static_cast<double>(n_here) / rules.share;
    return {.spacing = rules.spacing,
            .n_points = rules.n_points > 0 ? static_cast<double>(rules.n_points) : n,
            .noise_variance = rules.noise_variance,
            .typical_variance = rules.typical_variance,
            .contrary_share = rules.ladder.contrary_share};
}

}  // namespace

LevelCover::LevelCover(const PointBlock& points, const CoverRules& rules,
                       const PointPyramid& pyramid)
    : block_(points),
      rules_(rules),
      pyramid_(pyramid),
      leaves_(points, rules, pyramid_),
      states_(points, rules),
      second_(rules.fits_again() ? points.size() : 0),
      open_(points.size()),
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
        const std::size_t open = sift_open(thinning);
        reporter.progress("fit", n - open, n);
        if (open == 0) break;
        run_level(level, thinning);
        out_.counts.levels = static_cast<std::uint64_t>(level);
    }
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

/// Number of points that are open. Only all of them are sifted for good: the coarse levels look at
/// few, and are counted as they lie in memory.
std::size_t LevelCover::sift_open(std::size_t thinning) {
    if (thinning > 0) return states_.count_open();
    parallel_erase_if(open_, [&](std::uint32_t rank) { return is_closed(rank); });
    return open_.size();
}

void LevelCover::run_level(int level, std::size_t thinning) {
    const auto end = std::lower_bound(open_.begin(), open_.end(), pyramid_.level_size(thinning));
    std::vector<std::uint32_t> waiting(open_.begin(), end);
    if (thinning > 0)
        parallel_erase_if(waiting, [&](std::uint32_t rank) { return is_closed(rank); });
    for (std::uint32_t& rank : waiting) rank = pyramid_.by_priority()[rank];
    for (const float most_overlap : kCrowding) {
        run_pass(level, thinning, std::min(most_overlap, rules_.coverage()), waiting);
        if (waiting.empty()) break;
    }
}

/// Searches and accepts centres among the waiting points of a level whose overlap is not above a
/// limit; those above it are left in `waiting`. A point that lies in no core is open whatever its
/// overlap: the last pass takes them all.
void LevelCover::run_pass(int level, std::size_t thinning, float most_overlap,
                          std::vector<std::uint32_t>& waiting) {
    const bool last = most_overlap >= rules_.coverage();
    const auto may_lead = [&](std::uint32_t p) { return states_.may_lead(p, level); };
    const auto is_free = [&](std::uint32_t p) { return last || states_.weight(p) <= most_overlap; };

    BatchPlaces places(kConflict * level_radius(rules_.diagonal, level));
    std::vector<std::uint32_t> passed, later;
    std::vector<CoverCandidate> batch;
    for (std::size_t next = 0; next < waiting.size();) {
        batch.clear();
        passed.clear();
        places.clear();
        for (std::size_t clashes = 0; next < waiting.size() && batch.size() < kBatch; ++next) {
            states_.prefetch(waiting[std::min(next + kPrefetch, waiting.size() - 1)]);
            const std::uint32_t p = waiting[next];
            if (!may_lead(p)) continue;
            if (is_free(p)) {
                if (!places.add(block_.position[p]) && ++clashes * kLeastGain > batch.size()) break;
                batch.emplace_back().point = p;
            }
            passed.push_back(p);
        }
        parallel_blocks(batch.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) search(batch[i], level, thinning);
        });
        for (CoverCandidate& c : batch) {
            if (may_lead(c.point) && is_free(c.point))
                accept(c, level);
            else
                ++out_.counts.discarded;
        }
        // By priority, wherever the batch ended: those crowded before it and those crowded by it.
        std::copy_if(passed.begin(), passed.end(), std::back_inserter(later), may_lead);
    }
    waiting.swap(later);
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

Cover cover_points(const PointBlock& points, const CoverRules& rules, Reporter& reporter) {
    const PointPyramid pyramid(points, box_of(points), rules.seed, rules.share);
    if (!rules.ask_for_edges) return LevelCover(points, rules, pyramid).run(reporter);
    CoverRules decided = rules;
    const EdgeShare edges = edge_share(points, pyramid, edge_question(rules, points.size()));
    decided.sharp = edges.are_features();
    Cover cover = LevelCover(points, decided, pyramid).run(reporter);
    cover.edges = edges;
    return cover;
}

}  // namespace slim
