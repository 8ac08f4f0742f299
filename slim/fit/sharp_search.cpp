#include "slim/fit/sharp_search.h"

#include "slim/fit/sharp_filled.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr int kMostFailures = 4;        // steps without two clusters before an edge is in sight
constexpr double kRoughest = 0.07;      // eps over rho: beyond it sheets explain nothing
constexpr double kRoughestNoisy = 0.1;  // the same where eps is noise
constexpr double kExact = 0.001;        // eps over rho: such sheets hold in wider balls, too
constexpr float kElsewhere = 1e-8f;     // squared distance over rho: nearer is the centre's place
// radius of the leaf of a tip's own point over the way to the next: nothing is as wide there
constexpr double kOfTip = 0.1;
constexpr double kNoise = 1.2;          // eps^2 over lambda up to which it may be

/// Whether all points of a ball but the centre's own were set aside: of a tip.
bool is_tip(const BallPoints<float>& ball) {
    for (std::size_t i = 0; i < ball.n; ++i)
        if (ball.sq[i] > kElsewhere && ball.sq[i] < 1) return false;
    return true;
}

/// How near, over the radius, the nearest of those points lies.
double nearest_aside(const LadderWork& work) {
    double least = 1;
    for (const SetAside<float>& a : work.aside)
        if (a.sq > kElsewhere) least = std::min(least, std::sqrt(double{a.sq}));
    return least;
}

}  // namespace

double sq_roughest(double radius, double noise_variance) {
    const double sq = radius * radius;
    return std::max(kRoughest * kRoughest * sq,
                    std::min(kRoughestNoisy * kRoughestNoisy * sq, kNoise * noise_variance));
}

double sharp_price(std::size_t n_sheets) {
    constexpr double kSurfel = 12 * 4 + 24, kEntry = 12, kSheet = 8 * 4;
    return n_sheets < 2 ? 1 : 1 + (kEntry + kSheet * static_cast<double>(n_sheets - 1)) / kSurfel;
}

std::optional<SharpSearch::Rung> SharpSearch::evaluate(double radius, std::size_t& level,
                                                       const Vec3d& center,
                                                       LadderWork& work) const {
    gather_ball(points_.level(level), center, radius, work.ball);
    while (work.ball.n > rules_.sample && level + 1 < points_.n_levels())
        gather_ball(points_.level(++level), center, radius, work.ball);
    ++work.sharp_rungs;
    work.point_visits += work.ball.n;
    std::optional<Rung> best;
    const double t = energy_.length / radius;
    for (std::size_t k = 2; k <= kMostSheets; ++k) {
        const double price = sharp_price(k) * energy_.noise_variance * t * t;
        if (best && best->energy <= price) break;
        const auto fit = fit_sharp(work.ball, k, degree_, energy_.noise_variance, work.sharp);
        if (!fit || fit->sq_error > sq_roughest(radius, energy_.noise_variance)) continue;
        if (!within_noise(fit->n_off, work.ball.n, rules_.contrary_share)) continue;
        const double energy = fit->sq_error + price;
        const double freedom = std::max(fit->n_effective - fit->n_coefficients, 0.5);
        const double upper = energy + 2 * fit->sq_error * std::sqrt(2 / freedom);
        if (best && energy >= best->energy) continue;
        if (is_filled(*fit, work.ball, typical_variance_))
            best = Rung{{radius, k}, energy, upper, fit->sq_error};
    }
    return best;
}

std::optional<SharpSearch::Choice> SharpSearch::choose(const Vec3d& center,
                                                       const RadiusChoice& smooth,
                                                       LadderWork& work) const {
    if (smooth.isolated || !work.edge_in_sight) return std::nullopt;
    const double step = 1 / std::sqrt(kGoldenRatio);
    std::optional<Rung> best;
    double least_upper = smooth.energy;
    std::size_t level = 0;
    int failures = 0;
    const bool is_bent = smooth.energy - energy_.price(smooth.radius) >
                         kExact * kExact * smooth.radius * smooth.radius;
    // Planes need fewer points than the ladder's finest rung holds: one rung below it may do.
    for (double r = kGoldenRatio * smooth.finest; r <= root_radius_ * 1.000001; r *= step) {
        const auto rung = evaluate(r, level, center, work);
        if (!rung || rung->energy > least_upper) {
            // Exact sheets that cost too much for their size cost less in a larger ball.
            const bool may_pay =
                is_bent && rung && !best && rung->sq_error <= kExact * kExact * r * r;
            if (!may_pay && ++failures >= kMostFailures && r > smooth.radius) break;
            if (rung && best && rung->energy > rules_.give_up * least_upper) break;
            continue;
        }
        failures = 0;
        least_upper = std::min(least_upper, rung->upper);
        best = rung;
    }
    if (!best || best->energy > least_upper) return std::nullopt;
    return best->choice;
}

double SharpSearch::clear_radius(const Vec3d& center, const Vec3d& normal,
                                 const RadiusChoice& smooth, LadderWork& work) const {
    if (!smooth.forced || smooth.isolated || !work.edge_in_sight ||
        rules_.contrary_share >= kCleanNormals)
        return smooth.radius;
    gather_ball(points_.all(), center, smooth.radius, work.ball);
    set_contrary_aside(work.ball, normal, work.aside);
    double least = 1;
    for (const SetAside<float>& a : work.aside) least = std::min(least, std::sqrt(double{a.sq}));
    // Beside a point without a normal all others stand aside.
    if (sq_length(normal) > 0 && !work.aside.empty() && is_tip(work.ball))
        return smooth.radius * kOfTip * nearest_aside(work);
    return smooth.radius * std::max(least, kGoldenRatio * kGoldenRatio);
}

}  // namespace slim
