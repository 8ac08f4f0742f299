#include "slim/cover/level_cover.h"

#include "slim/base/parallel.h"
#include "slim/fit/radius_windows.h"
#include "slim/model/surfel_tree.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace slim {
namespace {

/// Centres far from the leaves so far come first: passes of a level, by the most overlap a centre
/// may have. In one pass, of random order, many leaves stand just outside another's reach and cover
/// little that is new (leaves of igea at T 0.02, bunny_raw and happy_stand_raw at 0.01: 6,458, 5,837,
/// 19,081 against 5,956, 5,399, 18,068 at the same errors; seven passes win no more).
constexpr float kCrowding[] = {0.008f, 0.025f, 0.06f, static_cast<float>(kCoverage)};
/// Of the diagonal of a bucket of 16 points: a ball with enough for the finest rung.
constexpr double kGuess = 0.4;
constexpr std::size_t kBatch = 256;         // searches between two rounds of acceptance; fixes the result
constexpr std::size_t kLookAhead = 4;       // batches of deferred centres before a round must start
constexpr double kBorder = 0.12;            // lean of a surfel at a border (0.2 if straight)
constexpr double kCorner = 0.22;            // lean at a corner (0.28 if right-angled)
constexpr double kClearlySmaller = 0.8;     // share of rho: the data further inwards ask for less
constexpr int kMostAttempts = 12;
constexpr double kSparse = 4;                // over the usual radius: a region so thin is a surface or strays
constexpr std::uint32_t kFewest = 3;         // points that any leaf may have
constexpr std::uint32_t kMany = 15;
constexpr double kThickOfSparse = 0.03;       // noise is small against so large a leaf
constexpr double kNarrowOfFew = 0.06;
constexpr double kNarrow = 0.2;              // breadth of a leaf whose points are a line (0.5 on a surface)
constexpr double kThick = 0.15;              // eps / rho of one whose points fill a volume (0.25 at random)
constexpr double kInwards = 0.45;           // of rho: how far its centre moves, so that it still covers the point
constexpr double kConflict = 0.5;           // share of rho_r within which two centres are not searched at once
constexpr std::size_t kWantedInBall = 128;  // points of a thinning in a ball of the level

/// One centre of a batch and what its search found.
struct Candidate {
    std::uint32_t point;
    std::uint32_t center = 0;  // the point that the leaf is centred at: `point`, or one further inwards
    bool leaf = false;
    RadiusChoice choice;
    std::size_t n_sheets = 1;            // of the leaf
    bool sparse = false;                 // the finest ball is far larger than usual
    CoveringSurfel surfel;               // of the leaf
    FittedSurfel internal;               // otherwise
    std::vector<std::uint32_t> stamped;  // points that the internal surfel keeps from becoming centres
};

struct Workspace {
    LadderWork ladder;
    SteadyWork exact;
    SharpWork<double> sharp;
    std::size_t searches = 0;
};

/// Where the centres of a batch stand: none nearer to another than a distance.
class BatchPlaces {
public:
    explicit BatchPlaces(double least_distance) : sq_(least_distance * least_distance) {}
    void clear() { x_.clear(), y_.clear(), z_.clear(); }
    /// False, and nothing is added, if p is too near to one that is there. Cost: a pass by lanes.
    bool add(const Vec3d& p) {
        unsigned n_near = 0;
        for (std::size_t i = 0; i < x_.size(); ++i) {
            const double dx = x_[i] - p.x, dy = y_[i] - p.y, dz = z_[i] - p.z;
            n_near += dx * dx + dy * dy + dz * dz < sq_ ? 1u : 0u;
        }
        if (n_near > 0) return false;
        x_.push_back(p.x), y_.push_back(p.y), z_.push_back(p.z);
        return true;
    }

private:
    double sq_;
    std::vector<double> x_, y_, z_;
};

/// The state of one run; each method is one step of it.
class LevelCover {
public:
    LevelCover(const PointBlock& points, const CoverRules& rules)
        : block_(points),
          rules_(rules),
          pyramid_(points, box_of(points), rules.seed),
          root_radius_(level_radius(rules.diagonal, rules.first_level)),
          ladder_(pyramid_, {rules.noise_variance, rules.mdl_threshold * rules.diagonal},
                  root_radius_, rules.least_radius, rules.degree, ladder_rules(rules)),
          windows_(pyramid_, {rules.noise_variance, rules.mdl_threshold * rules.diagonal},
                   root_radius_, rules.least_radius, rules.degree, rules.ladder),
          sharp_(pyramid_, {rules.noise_variance, rules.mdl_threshold * rules.diagonal},
                 root_radius_, usual_degree(rules), rules.ladder),
          weight_(points.size(), 0.0f),
          state_(points.size(), 0),
          stamp_(points.size(), 0),
          radius_(points.size(), 0.0f),
          degree_(points.size(), 0),
          place_(points.size()),
          open_(points.size()),
          work_([&rules] {
              Workspace w;
              w.ladder.ball.weight = w.exact.ball.weight = rules.weight;
              return w;
          }) {
        std::iota(open_.begin(), open_.end(), 0u);
        if (points.size() > 0) usual_radius_ = usual_radius();
        for (std::size_t i = 0; i < pyramid_.all().size(); ++i)
            place_[pyramid_.all().source(i)] = static_cast<std::uint32_t>(i);
        if (rules.owns)
            for (std::size_t i = 0; i < points.size(); ++i)
                if (!rules.owns(points.position[i])) state_[i] = kClosed;
    }

    Cover run(Reporter& reporter) {
        BallPoints<double> work;
        for (const FittedSurfel& s : rules_.done)
            if (s.flags & kLeaf)
                mark(s.surfel, covered_points(pyramid_.all(), s, rules_.noise_variance, work));
        std::size_t open = count_open();
        for (int level = rules_.first_level; level <= rules_.last_level && open > 0; ++level) {
            run_level(level);
            open = count_open();
            out_.counts.levels = static_cast<std::uint64_t>(level);
            reporter.progress("fit", block_.size() - open, block_.size());
        }
        for (const Workspace& w : work_) {
            out_.counts.rungs += w.ladder.rungs;
            out_.counts.sharp_rungs += w.ladder.sharp_rungs;
            out_.counts.refinements += w.ladder.refinements;
            out_.counts.point_visits += w.ladder.point_visits;
            out_.counts.evaluated += w.searches;
        }
        return std::move(out_);
    }

private:
    enum State : std::uint8_t {
        kCore = 1, kClosed = 2, kForced = 4, kSaturatedTop = 8, kLimited = 16,
        kTwoSheets = 32, kThreeSheets = 64,  // found by an earlier search: two sheets, three
        kThin = 128
    };

    /// Fine levels know no points beyond their halo: their balls must not exceed it.
    static LadderRules ladder_rules(const CoverRules& rules) {
        LadderRules ladder = rules.ladder;
        if (rules.first_level > 1) ladder.above_root = 0;
        ladder.look_for_edges = rules.sharp;
        return ladder;
    }
    /// Where the degree is not chosen one by one: of internal surfels, which stand in for their children where
    /// these are a few pixels large, and of edges, whose price is that of quadratic sheets.
    static int usual_degree(const CoverRules& rules) {
        return rules.ladder.choose_degree ? std::min(rules.degree, 2) : rules.degree;
    }
    static Bbox box_of(const PointBlock& points) {
        Bbox box;
        for (const Vec3d& p : points.position) box.extend(p);
        return box;
    }
    bool is_open(std::uint32_t p) const {
        if (state_[p] & kClosed) return false;
        return !((state_[p] & kCore) && weight_[p] >= static_cast<float>(kCoverage));
    }
    /// Median of 1,001 buckets' diagonals, the first guess of a ball with enough points.
    double usual_radius() const {
        const PointTree& tree = pyramid_.all();
        std::vector<double> sizes;
        for (std::size_t k = 0; k < 1001; ++k)
            sizes.push_back(tree.bucket_diagonal(k * (tree.size() - 1) / 1000));
        std::nth_element(sizes.begin(), sizes.begin() + 500, sizes.end());
        return kGuess * sizes[500];
    }
    std::size_t count_open() const {
        std::size_t n = 0;
        for (std::uint32_t p = 0; p < block_.size(); ++p) n += is_open(p) ? 1u : 0u;
        return n;
    }
    std::size_t thinning_for(double radius) const;
    /// The least radius of a leaf of this level.
    double lower_end(int level) const {
        return level_radius(rules_.diagonal, level) * kGoldenRatio * kGoldenRatio;
    }
    void run_level(int level);
    void run_pass(int level, std::size_t thinning, float most_overlap,
                  std::vector<std::uint32_t>& waiting);
    RadiusChoice choose_radius(std::uint32_t place, const Vec3d& normal, int level,
                               Workspace& work) const;
    void search(Candidate& c, int level, std::size_t thinning);
    void sharpen(Candidate& c, const Vec3d& center, Workspace& work) const;
    void make_internal(Candidate& c, double radius, std::size_t thinning, Workspace& work) const;
    void make_leaf(Candidate& c, int level, Workspace& work) const;
    CoveringSurfel fit_leaf(const Vec3d& center, const Vec3d& normal, const RadiusChoice& choice,
                            Workspace& work) const;
    std::optional<double> move_inwards(Candidate& c, int level, Workspace& work) const;
    std::optional<std::uint32_t> nearest_point(const Vec3d& p, double radius) const;
    void accept(Candidate& c, int level);
    void mark(const Surfel& leaf, const std::vector<Covered>& covered);
    void count(const CoveringSurfel& leaf);

    const PointBlock& block_;
    const CoverRules& rules_;
    PointPyramid pyramid_;
    double root_radius_;
    RadiusLadder ladder_;
    RadiusWindows windows_;
    SharpSearch sharp_;
    std::vector<float> weight_;        // sum of G over the leaves so far
    std::vector<std::uint8_t> state_;  // State flags
    std::vector<std::uint8_t> stamp_;  // level at which an internal surfel covers the point
    std::vector<float> radius_;        // found by an earlier search, 0: not searched
    std::vector<std::uint8_t> degree_;  // and the degree that goes with it
    std::vector<std::uint32_t> place_;  // of a point in the pyramid's full tree
    double usual_radius_ = 0;           // of a ball with enough points for the finest rung
    std::vector<std::uint32_t> open_;   // places in by_priority() of points that may be open, rising
    tbb::enumerable_thread_specific<Workspace> work_;
    Cover out_;
};

/// The coarsest thinning that still has enough points in a typical ball of this radius.
std::size_t LevelCover::thinning_for(double radius) const {
    const auto& order = pyramid_.by_priority();
    const std::size_t probes = std::min<std::size_t>(order.size(), 63);
    for (std::size_t t = pyramid_.n_levels(); t-- > 1;) {
        std::size_t full = 0;
        for (std::size_t i = 0; i < probes; ++i)
            full += count_in_ball(pyramid_.level(t), block_.position[order[i]], radius,
                                  kWantedInBall) >= kWantedInBall;
        if (2 * full > probes) return t;
    }
    return 0;
}

void LevelCover::run_level(int level) {
    const std::size_t thinning = thinning_for(level_radius(rules_.diagonal, level));
    std::erase_if(open_, [&](std::uint32_t rank) { return !is_open(pyramid_.by_priority()[rank]); });
    const auto end = std::lower_bound(open_.begin(), open_.end(), pyramid_.level_size(thinning));
    std::vector<std::uint32_t> waiting;
    for (auto rank = open_.begin(); rank != end; ++rank)
        waiting.push_back(pyramid_.by_priority()[*rank]);
    for (const float most_overlap : kCrowding) {
        run_pass(level, thinning, most_overlap, waiting);
        if (waiting.empty()) break;
    }
}

/// Searches and accepts centres among the waiting points of a level whose overlap is not above a limit; those
/// above it are left in `waiting`. A point that lies in no core is open whatever its overlap: the last pass
/// takes them all.
void LevelCover::run_pass(int level, std::size_t thinning, float most_overlap,
                          std::vector<std::uint32_t>& waiting) {
    const bool last = most_overlap >= static_cast<float>(kCoverage);
    const auto may_lead = [&](std::uint32_t p) { return is_open(p) && stamp_[p] != level; };
    const auto is_free = [&](std::uint32_t p) { return last || weight_[p] <= most_overlap; };

    BatchPlaces places(kConflict * level_radius(rules_.diagonal, level));
    std::vector<std::uint32_t> deferred, still, later;
    std::vector<Candidate> batch;
    std::size_t next = 0;
    while (true) {
        batch.clear();
        places.clear();
        still.clear();
        const auto consider = [&](std::uint32_t p) {
            if (!may_lead(p)) return;
            if (!is_free(p)) {
                later.push_back(p);
            } else if (batch.size() < kBatch && places.add(block_.position[p])) {
                batch.emplace_back();
                batch.back().point = p;
            } else {
                still.push_back(p);
            }
        };
        for (const std::uint32_t p : deferred) consider(p);
        while (batch.size() < kBatch && next < waiting.size() && still.size() < kLookAhead * kBatch)
            consider(waiting[next++]);
        deferred.swap(still);
        if (batch.empty()) break;
        parallel_blocks(batch.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) search(batch[i], level, thinning);
        });
        for (Candidate& c : batch) {
            if (may_lead(c.point) && is_free(c.point)) {
                accept(c, level);
                continue;
            }
            ++out_.counts.discarded;
            if (may_lead(c.point)) later.push_back(c.point);
        }
    }
    waiting.swap(later);
}

/// The radius about a point of the full tree.
RadiusChoice LevelCover::choose_radius(std::uint32_t place, const Vec3d& normal, int level,
                                       Workspace& work) const {
    const Vec3d center = pyramid_.all().position(place);
    ++work.searches;
    if (rules_.windows)
        return windows_.choose(center, normal, level - rules_.first_level, work.ladder);
    return ladder_.choose(center, normal, kGuess * pyramid_.all().bucket_diagonal(place),
                          work.ladder);
}

void LevelCover::search(Candidate& c, int level, std::size_t thinning) {
    Workspace& work = work_.local();
    const Vec3d center = block_.position[c.point];
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    c.center = c.point;
    if (radius_[c.point] > 0) {
        c.choice = {radius_[c.point], degree_[c.point], (state_[c.point] & kSaturatedTop) != 0,
                    (state_[c.point] & kForced) != 0, false, (state_[c.point] & kLimited) != 0};
        c.sparse = (state_[c.point] & kThin) != 0;
        c.n_sheets = state_[c.point] & kThreeSheets ? 3 : state_[c.point] & kTwoSheets ? 2 : 1;
    } else {
        c.choice = choose_radius(place_[c.point], normal, level, work);
        const double finest = c.choice.forced ? c.choice.radius : c.choice.finest;
        c.sparse = finest > kSparse * usual_radius_;
        if (rules_.sharp) sharpen(c, center, work);
        // Rounded here, so that a search remembered gives the same surfel as a fresh one.
        c.choice.radius = static_cast<float>(c.choice.radius);
    }
    c.leaf = c.choice.radius >= lower_end(level) && !c.choice.isolated;
    if (c.choice.isolated) return;
    if (c.leaf) make_leaf(c, level, work);
    if (!c.leaf && !c.choice.isolated) make_internal(c, level_radius(rules_.diagonal, level), thinning, work);
}

CoveringSurfel LevelCover::fit_leaf(const Vec3d& center, const Vec3d& normal,
                                    const RadiusChoice& choice, Workspace& work) const {
    // Where normals are clean and edges are looked for, wider balls would lend the edges' own curvature.
    const bool lends = !(rules_.sharp && rules_.ladder.contrary_share < kCleanNormals);
    if (lends && (choice.forced || choice.limited))
        return fit_steady_surfel(pyramid_, center, normal, choice.radius, choice.degree,
                                 choice.forced, rules_.noise_variance, work.exact);
    return fit_surfel(pyramid_.all(), center, normal, choice.radius, choice.degree,
                      choice.forced, rules_.noise_variance, work.exact.ball);
}

/// Gives a centre near an edge or a corner the radius and number of sheets that beat its smooth choice.
/// The exact fit must confirm them, here and not later, so that the smooth choice is still at hand.
void LevelCover::sharpen(Candidate& c, const Vec3d& center, Workspace& work) const {
    auto found = sharp_.choose(center, c.choice, work.ladder);
    if (!found) {
        const Vec3d normal = normalized(to_double(block_.normal[c.point]));
        c.choice.radius = static_cast<float>(sharp_.clear_radius(center, normal, c.choice, work.ladder));
        return;
    }
    found->radius = static_cast<float>(found->radius);
    auto fitted = fit_sharp_surfel(pyramid_.all(), center, *found, usual_degree(rules_),
                                   rules_.noise_variance, work.exact.ball, work.sharp);
    if (!fitted) return;
    c.surfel = std::move(*fitted);
    c.choice = {found->radius, usual_degree(rules_)};
    c.n_sheets = found->n_sheets;
}

/// Whether a leaf's points are no surface of its size: a pole, a twig, the crown of a tree. A disc among them
/// would stand in the air.
/// sparse: the finest ball with enough points is far larger than the cloud's usual one.
bool is_scatter(const CoveringSurfel& leaf, bool forced, bool sparse) {
    const FittedSurfel& f = leaf.fitted;
    if (f.n_points <= kFewest) return false;
    // A few points of a surface may look like a line; where the energy chose, a thick leaf is one of noise.
    const double narrow = f.n_points > kMany ? kNarrow : kNarrowOfFew;
    const double thick = sparse ? kThickOfSparse : kThick;
    const bool is_thick = (forced || sparse) && f.fit_error > thick * f.surfel.support_radius;
    const bool is_torn = sparse && 2 * leaf.n_aside > f.n_points;  // strays' normals agree on nothing
    // A scan line on a surface is a line too, but its normals agree; those about a pole do not.
    const bool is_line = leaf.breadth < narrow && 5 * leaf.n_aside > f.n_points;
    return is_line || is_thick || is_torn;
}

/// The leaf of a centre at its radius; at a border, one further inwards or smaller. c.leaf becomes false if
/// that is too small for this level: the point waits.
void LevelCover::make_leaf(Candidate& c, int level, Workspace& work) const {
    const double lower = lower_end(level);
    const Vec3d center = block_.position[c.point];
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    if (c.n_sheets > 1) {
        if (!c.surfel.fitted.surfel.sharp)  // the choice was made at an earlier level
            c.surfel = *fit_sharp_surfel(pyramid_.all(), center, {c.choice.radius, c.n_sheets},
                                         usual_degree(rules_), rules_.noise_variance, work.exact.ball,
                                         work.sharp);
        return;
    }
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
        c.surfel = fit_leaf(center, normal, c.choice, work);
        if (is_scatter(c.surfel, c.choice.forced, c.sparse)) {
            c.choice.radius = static_cast<float>(kGoldenRatio * c.choice.radius);
            c.leaf = c.choice.radius >= lower;
            if (!c.leaf) return;
            continue;
        }
        if (c.sparse && c.surfel.fitted.n_points <= kFewest) {  // strays, scattered in the air
            c.choice.isolated = true;
            c.leaf = false;
            return;
        }
        if (length(c.surfel.lean) <= kBorder) return;
        const std::optional<double> smaller = move_inwards(c, level, work);
        if (c.choice.forced) return;
        const bool at_corner = c.center == c.point && length(c.surfel.lean) > kCorner;
        if (!smaller && !at_corner) return;
        // A corner's leaf that cannot move inwards is tried at the next rung.
        c.choice.radius = static_cast<float>(smaller.value_or(kGoldenRatio * c.choice.radius));
        c.choice.saturated = false;
        c.leaf = c.choice.radius >= lower;
        if (!c.leaf) return;
    }
}

/// Index in the full tree of the point nearest to p within a radius.
std::optional<std::uint32_t> LevelCover::nearest_point(const Vec3d& p, double radius) const {
    std::optional<std::uint32_t> best;
    double best_sq = radius * radius;
    const PointTree& tree = pyramid_.all();
    tree.for_buckets_in_ball(p, radius, [&](std::size_t first, const PointBucket& bucket) {
        for (std::size_t k = 0; k < PointBucket::kSize; ++k) {
            const double sq = sq_length(Vec3d{bucket.x[k], bucket.y[k], bucket.z[k]} - p);
            if (sq >= best_sq) continue;
            best_sq = sq;
            best = static_cast<std::uint32_t>(first + k);
        }
    });
    return best;
}

/// A leaf centred at a border reaches alpha rho beyond the data. One centred further inwards that covers the
/// border point as well reaches beyond it by a quarter of that only; it takes the leaf's place if its
/// own radius allows it. If the radius there is smaller, the border must not have a larger one (a corner sees
/// a quarter of the data only): that radius is returned.
/// Departs from the paper, whose surfels overhang the borders of scans and sharp edges as discs.
std::optional<double> LevelCover::move_inwards(Candidate& c, int level, Workspace& work) const {
    const Vec3d from = block_.position[c.point];
    const double rho = c.surfel.fitted.surfel.support_radius;
    const Vec3d target = from + normalized(c.surfel.lean) * (kInwards * rho);
    const auto place = nearest_point(target, 0.5 * kInwards * rho);
    if (!place) return {};
    const PointTree& tree = pyramid_.all();
    const Vec3d center = tree.position(*place);
    const Vec3d normal = normalized(to_double(tree.normal(*place)));
    if (dot(normal, c.surfel.fitted.surfel.frame.normal) < kLeastCos) return {};
    const RadiusChoice choice = choose_radius(*place, normal, level, work);
    // Never larger than at the border: it still stands near it.
    const double radius = std::min<double>(static_cast<float>(choice.radius), rho);
    if (choice.forced || (rules_.owns && !rules_.owns(center))) return {};
    if (radius < kClearlySmaller * rho) return radius;
    if (radius < lower_end(level) || length(center - from) > 0.5 * radius) return {};
    RadiusChoice moved_choice = choice;
    moved_choice.radius = radius;
    CoveringSurfel moved = fit_leaf(center, normal, moved_choice, work);
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

void LevelCover::make_internal(Candidate& c, double radius, std::size_t thinning,
                               Workspace& work) const {
    const Vec3d center = block_.position[c.point];
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    const PointTree& tree = pyramid_.level(thinning);
    CoveringSurfel s = fit_surfel(tree, center, normal, radius, usual_degree(rules_), false,
                                  rules_.noise_variance, work.exact.ball);
    c.internal = s.fitted;
    gather_ball(tree, center, radius, work.exact.ball);
    for (std::size_t i = 0; i < work.exact.ball.n; ++i)
        c.stamped.push_back(tree.source(work.exact.ball.index[i]));
}

void LevelCover::accept(Candidate& c, int level) {
    radius_[c.point] = static_cast<float>(c.choice.radius);
    degree_[c.point] = static_cast<std::uint8_t>(c.choice.degree);
    if (c.choice.forced) state_[c.point] |= kForced;
    if (c.choice.saturated) state_[c.point] |= kSaturatedTop;
    if (c.choice.limited) state_[c.point] |= kLimited;
    if (c.sparse) state_[c.point] |= kThin;
    if (c.n_sheets > 1) state_[c.point] |= c.n_sheets == 3 ? kThreeSheets : kTwoSheets;
    if (c.choice.isolated) {
        state_[c.point] |= kClosed;
        ++out_.counts.isolated;
        return;
    }
    if (!c.leaf) {
        c.internal.level = static_cast<std::uint8_t>(level);
        c.internal.point_id = block_.id[c.point];
        out_.surfels.push_back(c.internal);
        ++out_.counts.internals;
        for (const std::uint32_t p : c.stamped) stamp_[p] = static_cast<std::uint8_t>(level);
        stamp_[c.point] = static_cast<std::uint8_t>(level);
        return;
    }
    state_[c.point] |= kClosed;
    if (!c.surfel.explains_center) {
        ++out_.counts.unexplained;
        return;
    }
    FittedSurfel& f = c.surfel.fitted;
    f.level = static_cast<std::uint8_t>(level);
    // The largest radius of fine levels is that of the halo: reaching it says nothing of E.
    const bool saturated = c.choice.saturated && rules_.first_level == 1;
    f.flags = static_cast<std::uint8_t>(kLeaf | (saturated ? kSaturated : 0) |
                                        (c.choice.forced ? slim::kForced : 0));
    f.point_id = block_.id[c.center];
    out_.counts.recentred += c.center != c.point;
    mark(f.surfel, c.surfel.covered);
    count(c.surfel);
    out_.counts.contrary += c.choice.limited;
    out_.surfels.push_back(f);
}

void LevelCover::mark(const Surfel& leaf, const std::vector<Covered>& covered) {
    const double sq_radius = leaf.support_radius * leaf.support_radius;
    const auto overlap = [&](const Covered& p) {
        if (rules_.reading == CoverReading::b) return p.weight;
        const double sq = sq_length(block_.position[p.point] - leaf.center) / sq_radius;
        return overlap_weight(rules_.reading, static_cast<float>(sq));
    };
    for (const Covered& p : covered) {
        weight_[p.point] += overlap(p);
        if (p.in_core) state_[p.point] |= kCore;
    }
}

void LevelCover::count(const CoveringSurfel& leaf) {
    CoverCounts& counts = out_.counts;
    ++counts.leaves;
    counts.saturated += (leaf.fitted.flags & kSaturated) != 0;
    counts.forced += (leaf.fitted.flags & slim::kForced) != 0;
    counts.normals_disagree += leaf.normals_disagree;
    counts.sharp_edges += leaf.fitted.surfel.n_sheets() == 2;
    counts.sharp_corners += leaf.fitted.surfel.n_sheets() == 3;
    ++counts.fallbacks[static_cast<std::size_t>(leaf.fallback)];
    ++counts.degrees[static_cast<std::size_t>(leaf.fitted.surfel.degree)];
}

}  // namespace

double level_radius(double diagonal, int level) {
    return diagonal / 10 * std::pow(kGoldenRatio, level - 1);
}

CoverCounts& CoverCounts::operator+=(const CoverCounts& b) {
    leaves += b.leaves, internals += b.internals, levels = std::max(levels, b.levels);
    saturated += b.saturated, forced += b.forced, contrary += b.contrary, normals_disagree += b.normals_disagree;
    unexplained += b.unexplained, isolated += b.isolated;
    sharp_edges += b.sharp_edges, sharp_corners += b.sharp_corners, sharp_rungs += b.sharp_rungs;
    recentred += b.recentred;
    evaluated += b.evaluated, discarded += b.discarded, rungs += b.rungs;
    refinements += b.refinements, point_visits += b.point_visits;
    for (std::size_t i = 0; i < fallbacks.size(); ++i) fallbacks[i] += b.fallbacks[i];
    for (std::size_t i = 0; i < degrees.size(); ++i) degrees[i] += b.degrees[i];
    return *this;
}

Cover cover_points(const PointBlock& points, const CoverRules& rules, Reporter& reporter) {
    return LevelCover(points, rules).run(reporter);
}

}  // namespace slim
