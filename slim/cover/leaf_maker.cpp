#include "slim/cover/leaf_maker.h"

#include "slim/base/parallel.h"
#include "slim/cover/leaf_end.h"
#include "slim/cover/scatter.h"
#include "slim/cover/strays.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

/// Of the diagonal of a bucket of 16 points: a ball with enough for the finest rung.
constexpr double kGuess = 0.4;
constexpr double kBorder = 0.12;            // lean of a surfel at a border (0.2 if straight)
constexpr double kCorner = 0.22;            // lean at a corner (0.28 if right-angled)
constexpr int kMostAttempts = 12;
constexpr double kResolved = 8;  // over the finest radius: a sample says nothing of finer detail
constexpr std::size_t kManyPoints = 300;    // of a ball: more say themselves where their leaf ends
// sqrt(lambda) over the spacing: from it on a single point's plane says little
constexpr double kBlurred = 0.25;
// points of a ball: of fewer there is no saying where a surface ends
constexpr std::size_t kFewForAir = 8;
constexpr double kThickForAir = 0.1;  // eps / rho: thicker leaves have no surface to stand off from
constexpr double kSparser = 1.3;  // times the usual finest ball: strays' may be as large
constexpr double kWaits = 1e-30;            // a radius that no level accepts

/// ends_with_points: leaves that go on past another sheet become smaller where they end.
LadderRules ladder_rules(const CoverRules& rules, bool ends_with_points) {
    LadderRules ladder = rules.ladder;
    if (ends_with_points) ladder.most_lean = 2 * kLeanOfBorder;
    ladder.top_rung = rules.top_rung();
    ladder.look_for_edges = rules.sharp;
    return ladder;
}

/// Whether a sample's search was decided by its points, not by their want.
bool resolves(const RadiusChoice& choice) {
    return !choice.forced && !choice.isolated && choice.radius >= kResolved * choice.finest;
}

/// The radius of the smallest ball that holds enough points.
double finest_of(const RadiusChoice& choice) {
    return choice.forced ? choice.radius : choice.finest;
}

}  // namespace

LeafMaker::LeafMaker(const PointBlock& points, const CoverRules& rules, const PointPyramid& pyramid)
    : block_(points),
      rules_(rules),
      pyramid_(pyramid),
      spacing_(rules.spacing > 0 || points.size() == 0 ? rules.spacing : spacing_here()),
      ladder_(pyramid, rules.energy(), level_radius(rules.diagonal, 1), rules.least_radius,
              rules.degree, ladder_rules(rules, ends_with_points())),
      windows_(pyramid, rules.energy(), level_radius(rules.diagonal, rules.first_level),
               rules.least_radius, rules.degree, rules.ladder),
      sharp_(pyramid, rules.energy(), rules.typical_variance,
             level_radius(rules.diagonal, 1 + rules.top_rung()), rules.usual_degree(),
             rules.ladder),
      place_(points.size()) {
    parallel_blocks(pyramid_.all().size(), 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            place_[pyramid_.all().source(i)] = static_cast<std::uint32_t>(i);
    });
}

/// By the median of 1,001 buckets' diagonals.
double LeafMaker::spacing_here() const {
    const PointTree& tree = pyramid_.all();
    std::vector<double> sizes;
    for (std::size_t k = 0; k < 1001; ++k)
        sizes.push_back(tree.bucket_diagonal(k * (tree.size() - 1) / 1000));
    std::nth_element(sizes.begin(), sizes.begin() + 500, sizes.end());
    return kGuess * sizes[500] / kFinestBall;
}

/// The radius about a point of the full tree.
RadiusChoice LeafMaker::choose_radius(std::uint32_t place, const Vec3d& normal, int level,
                                      LeafWork& work) const {
    const Vec3d center = pyramid_.all().position(place);
    ++work.searches;
    if (rules_.windows)
        return windows_.choose(center, normal, level - rules_.first_level, work.ladder);
    return ladder_.choose(center, normal, kGuess * pyramid_.all().bucket_diagonal(place),
                          work.ladder);
}

void LeafMaker::choose(LeafCandidate& c, LeafWork& work) const {
    const Vec3d center = block_.position[c.point];
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    c.choice = choose_radius(place_[c.point], normal, c.level, work);
    c.sparse = finest_of(c.choice) > kSparse * kFinestBall * spacing_ / std::sqrt(rules_.share);
    const bool is_resolved = !rules_.is_sample() || resolves(c.choice);
    if (!is_resolved) c.choice = {kWaits, c.choice.degree};
    if (rules_.sharp && is_resolved) sharpen(c, center, work);
    const bool may_widen = c.choice.limited && is_resolved && c.n_sheets == 1 && !rules_.windows;
    if (may_widen && relative_noise() < kLittleNoise) widen(c, center, normal, work);
    if (may_widen && are_edges_in_noise() && c.choice.degree < 3)
        widen_over_plate(c, center, normal, work);
    if (is_resolved && c.n_sheets == 1) end_with_points(center, normal, c.choice, work);
    // Rounded here, so that a search remembered gives the same surfel as a fresh one.
    c.choice.radius = static_cast<float>(c.choice.radius);
}

/// Whether a point, where points are sparser than usual, is one of a cloud's strays. A sample's are
/// all sparse.
bool LeafMaker::is_among_strays(const LeafCandidate& c, LeafWork& work) const {
    const double finest = finest_of(c.choice);
    const double density = rules_.stray_density;
    if (!(density > 0) || rules_.is_sample() || finest < kSparser * kFinestBall * spacing_)
        return false;
    return stands_among_strays(pyramid_.all(), block_.position[c.point], finest, density,
                               work.exact.ball);
}

bool LeafMaker::is_few_in_noise(const LeafCandidate& c) const {
    const double radius = c.choice.radius;
    if (!are_few_in_noise(0, radius, rules_.noise_variance)) return false;
    const std::size_t n =
        count_in_ball(pyramid_.all(), block_.position[c.point], radius, kFewOfForced + 1);
    return are_few_in_noise(n, radius, rules_.noise_variance);
}

CoveringSurfel LeafMaker::fit(const Vec3d& center, const Vec3d& normal,
                              const RadiusChoice& choice, LeafWork& work, Lists lists) const {
    CoveringSurfel leaf = fit_of_choice(center, normal, choice, work, lists);
    leaf.on_wire = rules_.lines_are_wires && is_wire(leaf);
    return leaf;
}

CoveringSurfel LeafMaker::fit_of_choice(const Vec3d& center, const Vec3d& normal,
                                        const RadiusChoice& choice, LeafWork& work,
                                        Lists lists) const {
    // Where normals are clean and edges are looked for, wider balls would lend the edges' own
    // curvature.
    const bool lends = !(rules_.sharp && rules_.ladder.contrary_share < kCleanNormals);
    if (lends && !choice.widened && (choice.forced || choice.limited))
        return fit_steady_surfel(pyramid_, center, normal, choice.radius, choice.degree,
                                 choice.forced, rules_.noise_variance, work.exact, lists);
    return fit_surfel(pyramid_.all(), center, normal, choice.radius, choice.degree,
                      choice.forced && !choice.widened, rules_.noise_variance, work.exact.ball,
                      edges(), lists);
}

/// sqrt(lambda) over the spacing.
double LeafMaker::relative_noise() const { return std::sqrt(rules_.noise_variance) / spacing_; }

/// Whether single points say where a sheet ends.
bool LeafMaker::ends_with_points() const { return relative_noise() < kBlurred; }

/// A leaf with its points, and where it stands in the air if it ended early.
CoveringSurfel LeafMaker::fit_with_air(const Vec3d& center, const Vec3d& normal,
                                       const RadiusChoice& choice, LeafWork& work) const {
    CoveringSurfel leaf = fit(center, normal, choice, work, Lists::left_out);
    list_with_air(choice, work, leaf);
    return leaf;
}

/// Adds the points of a leaf that was fitted last, and where it stands in the air. Real edges have
/// rims of their own (notes/0011).
void LeafMaker::list_with_air(const RadiusChoice& choice, const LeafWork& work,
                              CoveringSurfel& leaf) const {
    list_points(pyramid_.all(), work.exact.ball, rules_.noise_variance, leaf);
    const std::size_t n = work.exact.ball.n;
    const bool is_thin = leaf.fitted.fit_error <= kThickForAir * leaf.fitted.surfel.support_radius;
    const bool ended_early =
        (choice.forced || choice.limited) && n >= kFewForAir && n <= kManyPoints;
    if (ended_early && is_thin && edges() != Edges::real && ends_with_points())
        leaf.air = air_places(leaf.fitted.surfel, work.exact.ball);
}

/// A sparse leaf of few points is no disc as large as the gap about them: a mast's returns
/// (notes/0013). It does not wait for the level of its size: nobody else would cover them.
void LeafMaker::shrink_to_few(LeafCandidate& c, LeafWork& work) const {
    const double share = share_of_few(c.surfel);
    if (!(share < 1)) return;
    make_smaller(c, share * c.choice.radius, 0);
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    c.surfel = fit_with_air(block_.position[c.point], normal, c.choice, work);
}

/// A smaller radius; below `lower` the point waits.
void LeafMaker::make_smaller(LeafCandidate& c, double radius, double lower) {
    c.choice.radius = static_cast<float>(radius);
    c.choice.saturated = c.choice.widened = false;
    c.leaf = c.choice.radius >= lower;
}

void LeafMaker::make(LeafCandidate& c, double lower, LeafWork& work) const {
    make_whole(c, lower, work);
    if (c.leaf) keep_voids(c, lower, work);
}

/// The leaf, wherever its ball may have no points.
void LeafMaker::make_whole(LeafCandidate& c, double lower, LeafWork& work) const {
    const Vec3d center = block_.position[c.point];
    const Vec3d normal = normalized(to_double(block_.normal[c.point]));
    if (c.n_sheets > 1) {
        if (!c.surfel.fitted.surfel.sharp)  // the choice was made at an earlier level
            c.surfel = *fit_sharp_surfel(pyramid_.all(), center, {c.choice.radius, c.n_sheets},
                                         rules_.usual_degree(), rules_.noise_variance,
                                         work.exact.ball, work.sharp);
        return;
    }
    if (is_among_strays(c, work)) {
        c.choice.isolated = true;
        c.leaf = false;
        return;
    }
    bool may_end_at_edges = edges() == Edges::real && !c.choice.forced;
    // those past another sheet ended there when they were chosen
    bool may_end_at_points =
        rules_.refits && !c.choice.forced && !c.choice.past_sheet && ends_with_points();
    for (int attempt = 1; attempt <= kMostAttempts; ++attempt) {
        const Glance seen =
            attempt < kMostAttempts ? glance(c, center, normal, work) : Glance::undecided;
        if (seen == Glance::unexplained) {
            c.surfel = {};
            return;
        }
        if (seen == Glance::scatter) {
            make_smaller(c, kGoldenRatio * c.choice.radius, lower);
            if (!c.leaf) return;
            continue;
        }
        c.surfel = fit(center, normal, c.choice, work, Lists::left_out);
        const bool may_shrink = c.choice.forced && c.sparse;
        // In thick noise half of all fits are given up by their measures: nobody asks for their
        // points.
        bool is_given_up = is_scatter(c.surfel, c.choice.forced, c.sparse, is_clean()) ||
                           is_too_large_on_wire(c.surfel);
        if (may_shrink || (!is_given_up && !leaves_center(c)) || attempt == kMostAttempts)
            list_with_air(c.choice, work, c.surfel);
        if (may_shrink) {
            shrink_to_few(c, work);
            is_given_up = is_scatter(c.surfel, c.choice.forced, c.sparse, is_clean());
        }
        if (is_given_up || rounds_off(c.surfel) || is_too_large(c)) {
            make_smaller(c, rules_.is_sample() ? kWaits : kGoldenRatio * c.choice.radius, lower);
            if (!c.leaf) return;
            continue;
        }
        double share = std::exchange(may_end_at_edges, false)
                           ? share_before_edges(c.surfel, work.exact.ball)
                           : 1;
        if (share == 1 && std::exchange(may_end_at_points, false)) {
            share = share_at_end(c.surfel);
            if (share * c.choice.radius < c.choice.finest) share = 1;
        }
        if (share < 1) {
            make_smaller(c, share * c.choice.radius, lower);
            if (!c.leaf) return;
            continue;
        }
        if (c.sparse && c.surfel.fitted.n_points <= kFewest) {  // strays, scattered in the air
            c.choice.isolated = !rules_.is_sample();
            c.leaf = false;
            return;
        }
        if (length(c.surfel.lean) <= kBorder) return;
        const std::optional<double> smaller =
            move_inwards(c, normalized(c.surfel.lean), lower, work);
        if (c.choice.forced) return;
        const bool at_corner = c.center == c.point && length(c.surfel.lean) > kCorner;
        if (!smaller && !at_corner) return;
        // A corner's leaf that cannot move inwards is tried at the next rung. Few points lean by
        // chance: unless edges are looked for, no leaf becomes smaller than the finest ball that
        // its search admits.
        const double radius = smaller.value_or(kGoldenRatio * c.choice.radius);
        if (edges() != Edges::real && radius < c.choice.finest) return;
        make_smaller(c, radius, lower);
        if (!c.leaf) return;
    }
}

}  // namespace slim
