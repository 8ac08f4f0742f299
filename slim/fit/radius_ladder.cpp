#include "slim/fit/radius_ladder.h"

#include "slim/fit/least_share.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

// times the noise: a point with a contrary normal is another sheet's
constexpr double kOffSheet = 5;
constexpr double kForcedNoise = 4;  // eps^2 / lambda that a forced leaf is taken for
constexpr double kPoor = 0.1;  // eps^2 / lambda, which edges make, too: worth a look
// with the degree chosen: whose points the finest rung holds (notes/0004)
constexpr int kLeastChosen = 2;
constexpr double kClearlyMore = 1.2;  // times the sample: a ball is not
                                      // gathered to be thinned at once
// an optimum so little below a radius that 2 % are not worth a search
constexpr double kAtTheEnd = 1.2;
constexpr int kMostInDoubt = 3;  // rungs one after the other
constexpr int kMostRungs = 40;  // g^40 = 4e-9: finer than any double scan

}  // namespace

/// Clean clouds have no such noise, and one contrary normal ends the ladder; on raw scans one stray
/// normal would end it at once (happy_stand_raw, T 0.01: 42,000 leaves instead of 24,000).
bool within_noise(std::size_t count, std::size_t n, double share) {
    const double expected = share * static_cast<double>(n);
    return static_cast<double>(count) <= expected + 3 * std::sqrt(expected);
}

RadiusLadder::RadiusLadder(const PointPyramid& points, const MdlEnergy& energy,
                           double root_radius, double least_radius, int degree,
                           const LadderRules& rules)
    : points_(points),
      energy_(energy),
      root_radius_(root_radius),
      least_radius_(least_radius),
      degree_(degree),
      rules_(rules),
      last_rung_(0) {
    for (int rung = -rules_.above_root - 1; rung <= kMostRungs + 1; ++rung)
        radii_.push_back(root_radius * std::pow(kGoldenRatio, rung));
    while (last_rung_ < kMostRungs && rung_radius(last_rung_ + 1) >= least_radius_) ++last_rung_;
}

double RadiusLadder::rung_radius(int rung) const {
    return radii_[static_cast<std::size_t>(rung + rules_.above_root + 1)];
}

std::size_t RadiusLadder::least_points() const {
    const int least_degree = rules_.choose_degree ? kLeastChosen : degree_;
    const double wanted = std::ceil(rules_.points_per_coefficient * n_coefficients(least_degree));
    return std::min(static_cast<std::size_t>(wanted), points_.all().size());
}

/// The ball of that rung is in the workspace then, if it holds enough points.
int RadiusLadder::finest_rung(const Vec3d& center, double first_guess, LadderWork& work) const {
    const std::size_t enough = least_points();
    int rung = last_rung_;
    if (first_guess > 0)
        rung = std::clamp(
            static_cast<int>(std::log(first_guess / root_radius_) / std::log(kGoldenRatio)),
            std::min(rules_.top_rung, last_rung_), last_rung_);
    gather(0, center, rung_radius(rung), work);
    while (work.ball.n < enough && --rung >= coarsest_tried())
        gather(0, center, rung_radius(rung), work);
    if (work.ball.n < enough) return rung;
    const auto holds_enough = [&](int r) {
        const double ratio = rung_radius(r) / work.ball.radius;
        const auto sq_ratio = static_cast<float>(ratio * ratio);
        const auto end = work.ball.sq.begin() + static_cast<std::ptrdiff_t>(work.ball.n);
        return static_cast<std::size_t>(std::count_if(work.ball.sq.begin(), end, [&](float sq) {
                   return sq < sq_ratio;
               })) >= enough;
    };
    while (rung < last_rung_ && holds_enough(rung + 1)) ++rung;
    if (rung_radius(rung) < work.ball.radius) shrink_ball(work.ball, rung_radius(rung), work.ball);
    return rung;
}

/// Whether the ball of a rung, the smallest with enough points, has them all at its rim: a stray
/// point's ball reaches down to the surface, and its fit would be a large disc in the air. A
/// surface gives the next finer ball seven points; in clouds of a few points all may be far from
/// each other.
bool RadiusLadder::stands_alone(const Vec3d& center, int rung) const {
    return points_.all().size() > least_points() &&
           count_in_ball(points_.all(), center, rung_radius(rung + 1), 2) < 2;
}

/// The thinning of the next coarser rung, which holds 1/g^2 as many points of a surface as this
/// one.
std::size_t RadiusLadder::likely_level(const Rung& finer) const {
    const double n = static_cast<double>(finer.n) / (kGoldenRatio * kGoldenRatio);
    const bool thinned = n > kClearlyMore * static_cast<double>(rules_.sample);
    return std::min(finer.level + (thinned ? 1 : 0), points_.n_levels() - 1);
}

void RadiusLadder::gather(std::size_t level, const Vec3d& center, double radius,
                          LadderWork& work) const {
    work.level = level;
    gather_ball(points_.level(level), center, radius, work.ball);
}

/// The same after a fit: where that was of this very ball, only what it set aside is taken back.
void RadiusLadder::gather_again(std::size_t level, const Vec3d& center, double radius,
                                LadderWork& work) const {
    if (level != work.level || radius != work.ball.radius)
        return gather(level, center, radius, work);
    for (const SetAside<float>& a : work.aside) work.ball.sq[a.index] = a.sq;
}

/// Gathers a rung's ball, thinned from `level` on until the sample is not exceeded.
void RadiusLadder::gather_rung(int rung, std::size_t& level, const Vec3d& center,
                               LadderWork& work) const {
    const double radius = rung_radius(rung);
    const bool is_here = level == 0 && work.ball.radius == radius;  // the finest rung's
    if (!is_here) gather(level, center, radius, work);
    while (work.ball.n > rules_.sample && level + 1 < points_.n_levels())
        gather(++level, center, radius, work);
}

/// Whether the sheet goes on to the end of a rung's ball. Few points that face another way are
/// noise; many are the other side of a fold, where it ends, or of a gap, where it need not
/// (slim/cover/notes/0017).
SheetEnd RadiusLadder::end_of(const LadderFit& found, const LadderWork& work) const {
    const BallPoints<float>& ball = work.ball;
    const double tolerance =
        kOffSheet * std::sqrt(std::min(found.fit.sq_error, energy_.noise_variance));
    const std::size_t off =
        count_off_sheet<float>(ball, work.aside, found.frame, found.fit, tolerance);
    if (within_noise(off, ball.n, rules_.contrary_share)) return SheetEnd::alone;
    if (rules_.look_for_edges) return SheetEnd::ends;  // sheets of an acute edge, of a thin plate
    const double explained =
        energy_.noise_variance + energy_of(found.degree).price(ball.radius);
    return end_of_sheet<float>(
        ball, work.aside,
        {found.frame, found.fit, explained, tolerance, rules_.contrary_share, rules_.most_lean});
}

std::optional<RadiusLadder::Rung> RadiusLadder::evaluate(int rung, std::size_t level,
                                                         const Vec3d& center, const Vec3d& normal,
                                                         LadderWork& work) const {
    const double radius = rung_radius(rung);
    gather_rung(rung, level, center, work);
    const std::size_t n_sample = work.ball.n;
    ++work.rungs;
    LadderFit found = fit_gathered(normal, work);
    // What is missed must be known as well as E asks for;
    // only balls that show noise alone need more points.
    for (std::size_t finer = level;
         finer > 0 && work.ball.n < rules_.most_sample / 3 &&
         2 * found.fit.sq_missed_error > energy_of(found.degree).price(radius);) {
        gather(--finer, center, radius, work);
        found = fit_gathered(normal, work);
    }
    const LocalFit& fit = found.fit;
    const SheetEnd end = end_of(found, work);
    if (end == SheetEnd::ends) return std::nullopt;
    const MdlEnergy mdl = energy_of(found.degree);
    const double energy = mdl(fit.sq_error, radius);
    const double upper = mdl.upper_bound(fit, radius);
    const double missed = fit.sq_missed + mdl.price(radius);
    return Rung{.index = rung,
                .level = level,
                .degree = found.degree,
                .end = end,
                .n = n_sample,
                .energy = energy,
                .upper = upper,
                .noise = energy - missed,
                .noise_upper = upper - missed,
                .missed = missed + fit.sq_missed_slope,
                .missed_error = 2 * fit.sq_missed_error,
                .sq_radius = radius * radius,
                .slope = fit.sq_slope_error,
                .slope_upper = fit.sq_slope_error * (1 + 2 / std::sqrt(fit.n_effective))};
}

RadiusLadder::LadderFit RadiusLadder::fit_gathered(const Vec3d& normal, LadderWork& work) const {
    work.point_visits += work.ball.n;
    const Vec3d n = average_normal(work.ball, 1, normal).normal;
    LadderFit out{frame_from_normal(n), degree_, {}};
    set_contrary_aside(work.ball, n, work.aside);
    if (rules_.choose_degree)
        fit_cheapest(work.ball, out);
    else
        out.fit = fit_ball_ahead(work.ball, 1, out.frame, degree_);
    if (is_rounding(out.fit.sq_error, work.ball.radius))
        out.fit.sq_missed = out.fit.sq_missed_error = out.fit.sq_missed_slope =
            out.fit.sq_slope_error = 0;
    out.fit.sq_error = std::max(out.fit.sq_error, rules_.least_sq_error);
    return out;
}

MdlEnergy RadiusLadder::energy_of(int degree) const {
    return rules_.choose_degree ? energy_.at_price(degree_price(degree)) : energy_;
}

/// The fit of the degree that has the least energy in this ball.
void RadiusLadder::fit_cheapest(const BallPoints<float>& ball, LadderFit& out) const {
    const auto fits = fit_every_degree(ball, 1, out.frame);
    double least = INFINITY;
    for (int d = 1; d <= degree_; ++d) {
        const LocalFit& fit = fits[static_cast<std::size_t>(d - 1)];
        const double enough = rules_.points_per_coefficient * n_coefficients(d);
        if (d > 1 && (fit.degree < d || static_cast<double>(fit.n_points) < enough)) break;
        const double sq_error = std::max(fit.sq_error, rules_.least_sq_error);
        const double energy = energy_of(d)(sq_error, ball.radius);
        if (energy >= least) continue;
        least = energy;
        out.degree = d;
        out.fit = fit;
    }
}

/// eps^2 of a noisy ball is noise, known to two standard errors only: a fifth of it with some
/// hundred points, in which a bias of half the noise hides. What the next degree would find shows a
/// tenth of that. So the rungs are taken to have the same noise as far as their errors allow. Where
/// normals count, what turns them is the same in all rungs, too: on an axis of symmetry the next
/// degree finds nothing, and the one after it turns slopes (a torus' inner equator).
int RadiusLadder::largest_as_good(std::span<const std::optional<Rung>> rungs) {
    double noise = INFINITY, least = INFINITY;
    double slope = INFINITY;
    for (const auto& r : rungs) {
        noise = std::min(noise, r->noise_upper);
        if (r->slope > 0) slope = std::min(slope, r->slope_upper);
    }
    const auto cost = [&](const Rung& r) {
        return std::max(0.0, r.noise - noise) + r.missed +
               r.sq_radius * std::max(0.0, r.slope - slope);
    };
    for (const auto& r : rungs) least = std::min(least, cost(*r) + r->missed_error);
    const auto found = std::find_if(rungs.begin(), rungs.end(),
                                    [&](const auto& r) { return cost(*r) <= least; });
    return found->value().index;
}

/// Where normals tell what a rung misses, its energy is that and the price: least in closed form,
/// what is missed being C rho^2p (NUMERICS 3.2). eps^2 would only add its noise to the choice.
double RadiusLadder::known_optimum(const Rung& chosen, double lo, double hi) const {
    const double rho = rung_radius(chosen.index), price = energy_of(chosen.degree).price(rho);
    const double p = chosen.degree + 1, missed = chosen.missed - price;
    if (!(missed > 0)) return hi;
    return std::clamp(rho * std::pow(price / (p * missed), 1 / (2 * p + 2)), lo, hi);
}

/// Whether the energy has no minimum short of the coarsest admissible rung, the chosen one. With
/// eps^2 = noise + C rho^2p (NUMERICS 3.2) there is one where C rho^2p exceeds price / p, which the
/// two last rungs tell. Where eps^2 fell by more than the price, they are no such pair: a search
/// there keeps clean clouds as they are. Two in five refinements of happy_stand_raw, whose ladders
/// mostly end at a fold, would find the end itself.
bool RadiusLadder::falls_to_the_end(const Rung& chosen, const Rung& finer) const {
    if (chosen.degree != finer.degree) return false;
    const double p = chosen.degree + 1,
                 price = energy_of(chosen.degree).price(rung_radius(chosen.index));
    const double rise =
        chosen.energy - finer.energy + price * (1 / (kGoldenRatio * kGoldenRatio) - 1);
    return rise > -price && rise < kAtTheEnd * price / p * (1 - std::pow(kGoldenRatio, 2 * p));
}

double RadiusLadder::refine(const Rung& chosen, double lo, double hi, const Vec3d& center,
                            const Vec3d& normal, LadderWork& work) const {
    if (work.ball.normals_count) return known_optimum(chosen, lo, hi);
    gather_again(chosen.level, center, hi, work);
    const double middle = rung_radius(chosen.index) / hi;
    const Frame<double> frame = frame_from_normal(average_normal(work.ball, middle, normal).normal);
    set_contrary_aside(work.ball, frame.normal, work.aside);
    const MdlEnergy energy = energy_of(chosen.degree);
    const auto energy_at = [&](double log_share) {
        const double radius = std::exp(log_share) * hi;
        ++work.refinements;
        work.point_visits += work.ball.n;
        const LocalFit fit = fit_ball(work.ball, radius / hi, frame, chosen.degree);
        return energy(fit.sq_error, radius);
    };
    return least_share(std::log(lo / hi), energy_at) * hi;
}

RadiusChoice RadiusLadder::choose(const Vec3d& center, const Vec3d& normal, double first_guess,
                                  LadderWork& work) const {
    const int finest = finest_rung(center, first_guess, work);
    work.edge_in_sight = false;
    if (finest <= 0 && stands_alone(center, finest))
        return {rung_radius(finest), degree_, false, true, true};
    if (finest < rules_.top_rung)
        return {rung_radius(finest), degree_, false, true, finest < coarsest_tried()};
    const double forced_energy =
        energy_(kForcedNoise * energy_.noise_variance, rung_radius(finest));
    std::optional<Rung> rungs[kMostRungs + 1];
    double least_upper = INFINITY;
    std::size_t level = 0;
    int coarsest = finest + 1;
    bool folded = false, in_doubt = false;
    for (int r = finest; r >= rules_.top_rung; --r) {
        rungs[r] = evaluate(r, level, center, normal, work);
        in_doubt = rungs[r] && rungs[r]->end == SheetEnd::in_doubt;
        folded = !rungs[r] || (in_doubt && coarsest - r > kMostInDoubt);
        if (folded) break;
        if (!in_doubt) coarsest = r;
        level = likely_level(*rungs[r]);
        least_upper = std::min(least_upper, rungs[r]->upper);
        if (rungs[r]->energy > rules_.give_up * least_upper) break;
    }
    folded |= in_doubt;
    if (rules_.look_for_edges) work.edge_in_sight = shows_edge(work.ball) || shows_faces(work.ball);
    if (coarsest > finest)
        return {rung_radius(finest), degree_,       false,              true, false, true,
                forced_energy,       rung_radius(finest)};
    const int chosen = largest_as_good(
        std::span(rungs).subspan(static_cast<std::size_t>(coarsest),
                                 static_cast<std::size_t>(finest - coarsest + 1)));
    // Where even the finest ball but one is poor, or the best is, the last one may be too large to
    // show an edge, or hold more faces than are told apart.
    const double unexplained = rungs[chosen]->energy - energy_.price(rung_radius(chosen));
    const bool is_poor = unexplained > kPoor * energy_.noise_variance;
    if (rules_.look_for_edges && (chosen == finest || is_poor))
        work.edge_in_sight |= normal_spread(work.ball) >= kLeastSpread;
    const bool saturated = chosen == 0;
    const bool limited = folded && chosen == coarsest;
    const double lo = chosen < finest ? rung_radius(chosen + 1) : rung_radius(chosen);
    const double hi = chosen > coarsest ? rung_radius(chosen - 1) : rung_radius(chosen);
    const double energy = rungs[chosen]->energy;
    const int degree = rungs[chosen]->degree;
    const bool at_the_end = saturated || lo == hi ||
                            (chosen == coarsest && !work.ball.normals_count &&
                             falls_to_the_end(*rungs[chosen], *rungs[chosen + 1]));
    const double radius =
        at_the_end ? rung_radius(chosen) : refine(*rungs[chosen], lo, hi, center, normal, work);
    const bool past_sheet = rungs[chosen]->end != SheetEnd::alone;
    return {radius, degree, saturated, false, false, limited, energy, rung_radius(finest),
            false, past_sheet};
}

}  // namespace slim
