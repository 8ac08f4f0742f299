#include "slim/fit/radius_windows.h"

#include "slim/fit/least_share.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace slim {
namespace {

constexpr int kFinestWindow = 24;   // NUMERICS 3.3, last row
constexpr double kLevel = 1e-3;     // share of E that counts as no rise

}  // namespace

/// The rungs of one search, each evaluated once: windows share their ends.
class RadiusWindows::Search {
public:
    Search(const RadiusWindows& rules, const Vec3d& center, const Vec3d& normal, LadderWork& work)
        : rules_(rules), center_(center), normal_(normal), work_(work) {}

    double radius(int rung) const { return rules_.root_radius_ * std::pow(kGoldenRatio, rung); }
    /// Whether the window has points at its l, and that is above rounding.
    bool is_held(int window) const {
        const double l = radius(window + 2);
        const std::size_t needed = 2 * static_cast<std::size_t>(n_coefficients(rules_.degree_));
        return window < kFinestWindow && l >= rules_.least_radius_ &&
               count_in_ball(rules_.points_.all(), center_, l, needed) == needed;
    }
    /// Radius of the smallest ball that may be looked at: the l of the finest window that is held.
    double finest() const {
        int window = kFinestWindow - 1;
        while (window > 0 && !is_held(window)) --window;
        return radius(window + 2);
    }
    bool is_minimum(int window) {
        const Rung l = rung(window + 2), m = rung(window + 1), r = rung(window);
        return l.energy > m.energy && m.energy < r.energy && l.sq_error < m.sq_error &&
               m.sq_error < r.sq_error;
    }
    bool falls_upwards(int window) {
        const double least = std::min(rung(window + 1).energy, rung(window + 2).energy);
        return rung(window).energy <= least * (1 + kLevel);
    }
    double energy(int window) { return rung(window).energy; }
    /// Brent's minimum of E in the window, in one frame and on one sample (NUMERICS 2.1).
    double minimum(int window);

private:
    struct Rung {
        double energy, sq_error;
    };
    std::size_t gather(double ball_radius);
    Rung rung(int index);

    const RadiusWindows& rules_;
    const Vec3d& center_;
    const Vec3d& normal_;
    LadderWork& work_;
    std::array<std::optional<Rung>, kFinestWindow + 2> rungs_;
};

/// The ball of at most `sample` points.
std::size_t RadiusWindows::Search::gather(double ball_radius) {
    std::size_t level = 0;
    gather_ball(rules_.points_.level(level), center_, ball_radius, work_.ball);
    while (work_.ball.n > rules_.sample_ && level + 1 < rules_.points_.n_levels())
        gather_ball(rules_.points_.level(++level), center_, ball_radius, work_.ball);
    return work_.ball.n;
}

RadiusWindows::Search::Rung RadiusWindows::Search::rung(int index) {
    std::optional<Rung>& known = rungs_[static_cast<std::size_t>(index)];
    if (known) return *known;
    ++work_.rungs;
    work_.point_visits += gather(radius(index));
    const Vec3d n = average_normal(work_.ball, 1, normal_).normal;
    set_contrary_aside(work_.ball, n, work_.aside);
    const LocalFit fit = fit_ball(work_.ball, 1, frame_from_normal(n), rules_.degree_);
    known = Rung{rules_.energy_(fit.sq_error, radius(index)), fit.sq_error};
    return *known;
}

double RadiusWindows::Search::minimum(int window) {
    const double r = radius(window);
    gather(r);
    const Frame<double> frame =
        frame_from_normal(average_normal(work_.ball, kGoldenRatio, normal_).normal);
    set_contrary_aside(work_.ball, frame.normal, work_.aside);
    const auto energy_at = [&](double log_share) {
        const double shrink = std::exp(log_share);
        ++work_.refinements;
        work_.point_visits += work_.ball.n;
        const LocalFit fit = fit_ball(work_.ball, shrink, frame, rules_.degree_);
        return rules_.energy_(fit.sq_error, shrink * r);
    };
    return least_share(2 * std::log(kGoldenRatio), energy_at) * r;
}

RadiusChoice RadiusWindows::choose(const Vec3d& center, const Vec3d& normal, int first,
                                   LadderWork& work) const {
    work.edge_in_sight = false;
    Search search(*this, center, normal, work);
    int window = first;
    while (window > 0 && search.is_held(window) && search.falls_upwards(window)) --window;
    for (;; ++window) {
        RadiusChoice choice;
        choice.radius = choice.finest = search.radius(window);
        choice.degree = degree_;
        choice.forced = !search.is_held(window);
        if (choice.forced) return choice;
        choice.finest = search.finest();
        choice.energy = search.energy(window);
        choice.saturated = window == 0 && search.falls_upwards(window);
        if (choice.saturated) return choice;
        if (!search.is_minimum(window)) continue;
        choice.radius = search.minimum(window);
        return choice;
    }
}

}  // namespace slim
