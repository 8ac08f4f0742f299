#include "slim/cover/surfel_fit.h"

#include "slim/model/surfel_tree.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr float kAtCenter = 0.9999999f;
constexpr double kWithinNoise = 4;  // eps^2 / lambda of a forced leaf that needs no higher degree
constexpr double kExplained = 4;  // residuals up to this many eps belong to the surfel
constexpr double kBeside = 9;     // up to this many sqrt(lambda): beside it; rims scatter so far
constexpr double kNotBeside = 0.35;  // of rho: no farther, or what the surfel is blended from ends

/// Points with a bad normal, but not one that faces the other way, are covered like others if their place is
/// right; left open they would become centres of their own and speckle a curvature map.
void take_back(BallPoints<double>& ball, const Vec3d& normal,
               const std::vector<SetAside<double>>& aside) {
    const Vec3f n = to_float(normal);
    for (const SetAside<double>& a : aside) {
        const std::size_t i = a.index;
        if (ball.nx[i] * n.x + ball.ny[i] * n.y + ball.nz[i] * n.z >= kOtherSideCos)
            ball.sq[i] = a.sq;
    }
}

/// Whether a point's normal faces the other way than the sheet that it lies nearest to.
bool faces_away(const Surfel& s, const Vec3d& x, const Vec3d& normal) {
    const Vec3d g = s.sheet_gradient(s.active_sheet(x), x);
    return dot(g, normal) < static_cast<double>(kOtherSideCos) * length(g);
}

/// Lists the ball's points that the surfel explains and those beside it. Other sheets' points have
/// sq = 2 and are passed over.
void list_covered(const PointTree& tree, const BallPoints<double>& ball, double noise_variance,
                  CoveringSurfel& out) {
    const Surfel& s = out.fitted.surfel;
    const double noise = std::sqrt(noise_variance);
    const double tolerance = std::min(
        kExplained * std::max(out.fitted.fit_error, noise) / s.support_radius, kBelongs);
    const double beside = std::min(kBeside * noise / s.support_radius, kNotBeside);
    for (std::size_t i = 0; i < ball.n; ++i) {
        if (ball.sq[i] >= 1) continue;
        const Vec3d x{ball.x[i], ball.y[i], ball.z[i]};
        const double off = std::abs(s.value(x));
        if (!(off <= std::max(tolerance, beside))) continue;
        if (s.sharp && faces_away(s, x, {ball.nx[i], ball.ny[i], ball.nz[i]})) continue;
        const std::uint32_t point = tree.source(ball.index[i]);
        if (off <= tolerance)
            out.covered.push_back({point, static_cast<float>(weight_kernel(ball.sq[i])),
                                   ball.sq[i] < kTrim * kTrim});
        else
            out.beside.push_back(point);
    }
    // The heaviest weight is G(0) = 1, which only points at the centre have.
    for (const Covered& c : out.covered) out.explains_center |= c.weight >= kAtCenter;
}

/// Weighted mean of the points that take part, along the tangent plane; 0.2 at a straight border.
Vec3d lean_of(const BallPoints<double>& ball, const Vec3d& normal) {
    Vec3d sum;
    double weight = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const double g = weight_kernel(ball.sq[i]);
        sum += Vec3d{ball.x[i], ball.y[i], ball.z[i]} * g;
        weight += g;
    }
    if (!(weight > 0)) return {};
    const Vec3d mean = sum / weight;
    return mean - normal * dot(mean, normal);
}

/// Least RMS width of the points that take part, in the tangent plane about their mean, over rho.
double breadth_of(const BallPoints<double>& ball, const Frame<double>& frame) {
    double weight = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const double g = ball.sq[i] < 1 ? 1.0 : 0.0;  // under G a few points are a line by chance
        const Vec3d x = frame.local_from_world(Vec3d{ball.x[i], ball.y[i], ball.z[i]});
        weight += g, u += g * x.x, v += g * x.y;
        uu += g * x.x * x.x, uv += g * x.x * x.y, vv += g * x.y * x.y;
    }
    if (!(weight > 0)) return 0;
    u /= weight, v /= weight;
    const double a = uu / weight - u * u, b = uv / weight - u * v, c = vv / weight - v * v;
    return std::sqrt(std::max(0.0, (a + c) / 2 - std::hypot((a - c) / 2, b)));
}

/// The fit of a ball in the frame of its rounded normal, and what was set aside for it.
struct BallFit {
    Frame<double> frame;
    LocalFit fit;
    std::vector<SetAside<double>> aside;
    bool normals_disagree;
};

BallFit fit_all_points(const PointTree& points, const Vec3d& center, const Vec3d& normal,
                       double radius, int degree, bool forced, double noise_variance,
                       BallPoints<double>& ball) {
    gather_ball(points, center, radius, ball);
    const BallNormal average = average_normal(ball, 1, normal);
    BallFit out{frame_from_normal(round_normal(average.normal)), {}, {}, average.disagree};
    set_contrary_aside(ball, out.frame.normal, out.aside);
    out.fit = fit_ball(ball, 1, out.frame, forced ? 1 : degree);
    for (int d = 2; forced && d <= degree && out.fit.sq_error > kWithinNoise * noise_variance; ++d)
        out.fit = fit_ball(ball, 1, out.frame, d);
    if (out.fit.fallback == Fallback::none && out.fit.degree < degree)
        out.fit.fallback = Fallback::lower_explains;
    return out;
}

CoveringSurfel cover_by(const PointTree& points, const Vec3d& center, const BallFit& ball_fit,
                        double noise_variance, BallPoints<double>& ball) {
    const LocalFit& fit = ball_fit.fit;
    CoveringSurfel out;
    out.lean = lean_of(ball, ball_fit.frame.normal);
    out.n_aside = ball_fit.aside.size();
    out.breadth = breadth_of(ball, ball_fit.frame);
    take_back(ball, ball_fit.frame.normal, ball_fit.aside);
    out.fitted.surfel = {center, ball.radius, ball_fit.frame, fit.polynomial, fit.degree};
    out.fitted.fit_error = std::sqrt(fit.sq_error);
    out.fitted.n_points = static_cast<std::uint32_t>(fit.n_points);
    out.fallback = fit.fallback;
    out.normals_disagree = ball_fit.normals_disagree;
    list_covered(points, ball, noise_variance, out);
    return out;
}

}  // namespace

CoveringSurfel fit_surfel(const PointTree& points, const Vec3d& center, const Vec3d& normal,
                          double radius, int degree, bool forced, double noise_variance,
                          BallPoints<double>& ball) {
    const BallFit fit =
        fit_all_points(points, center, normal, radius, degree, forced, noise_variance, ball);
    return cover_by(points, center, fit, noise_variance, ball);
}

CoveringSurfel fit_steady_surfel(const PointPyramid& points, const Vec3d& center,
                                 const Vec3d& normal, double radius, int degree, bool forced,
                                 double noise_variance, SteadyWork& work) {
    BallFit fit = fit_all_points(points.all(), center, normal, radius, degree, forced,
                                 noise_variance, work.ball);
    fit.fit = steady_curvature(points, {center, fit.frame, work.ball, fit.fit}, degree,
                               noise_variance, work.wider);
    if (fit.fit.degree == degree) fit.fit.fallback = Fallback::none;
    return cover_by(points.all(), center, fit, noise_variance, work.ball);
}

std::optional<CoveringSurfel> fit_sharp_surfel(const PointTree& points, const Vec3d& center,
                                               const SharpSearch::Choice& choice, int degree,
                                               double noise_variance, BallPoints<double>& ball,
                                               SharpWork<double>& sharp) {
    gather_ball(points, center, choice.radius, ball);
    const auto fit = fit_sharp(ball, choice.n_sheets, degree, noise_variance, sharp);
    if (!fit) return std::nullopt;
    CoveringSurfel out;
    out.fitted.surfel = fit->surfel(center, choice.radius);
    out.fitted.fit_error = std::sqrt(fit->sq_error);
    out.fitted.n_points = static_cast<std::uint32_t>(fit->n_points);
    list_covered(points, ball, noise_variance, out);
    if (!out.explains_center) return std::nullopt;
    return out;
}

CoveringSurfel cover_again(const PointTree& points, const FittedSurfel& fitted,
                           double noise_variance, BallPoints<double>& ball) {
    CoveringSurfel out;
    out.fitted = fitted;
    gather_ball(points, fitted.surfel.center, fitted.surfel.support_radius, ball);
    if (!fitted.surfel.sharp) {
        std::vector<SetAside<double>> aside;
        set_contrary_aside(ball, fitted.surfel.frame.normal, aside);
        take_back(ball, fitted.surfel.frame.normal, aside);
    }
    list_covered(points, ball, noise_variance, out);
    return out;
}

}  // namespace slim
