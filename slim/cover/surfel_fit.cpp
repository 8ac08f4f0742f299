#include "slim/cover/surfel_fit.h"

#include "slim/model/surfel_encoder.h"
#include "slim/model/surfel_tree.h"

#include <cmath>

namespace slim {
namespace {

constexpr double kWithinNoise = 4;  // eps^2 / lambda of a forced leaf that needs no higher degree

/// Points with a bad normal, but not one that faces the other way, are covered like others if their
/// place is right; left open they would become centres of their own and speckle a curvature map.
void take_back(BallPoints<double>& ball, const Vec3d& normal,
               const std::vector<SetAside<double>>& aside) {
    const Vec3f n = to_float(normal);
    for (const SetAside<double>& a : aside) {
        const std::size_t i = a.index;
        if (ball.nx[i] * n.x + ball.ny[i] * n.y + ball.nz[i] * n.z >= kOtherSideCos)
            ball.sq[i] = a.sq;
    }
}

/// The fit of a ball in the frame of its rounded normal, and what was set aside for it.
struct BallFit {
    Frame<double> frame;
    LocalFit fit;
    std::vector<SetAside<double>> aside;
    bool normals_disagree;
};

/// Whether a ball's normals are those of more than one face: some were set aside, or stand at 30
/// degrees or more to the frame's.
bool holds_edge(const BallPoints<double>& ball, const BallFit& fit) {
    if (!fit.aside.empty()) return true;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const Vec3d n{ball.nx[i], ball.ny[i], ball.nz[i]};
        if (dot(n, fit.frame.normal) < kEdgeCos * sq_length(n)) return true;
    }
    return false;
}

BallFit fit_gathered(const Vec3d& normal, int degree, bool forced, double noise_variance,
                     Enough enough, Edges edges, BallPoints<double>& ball) {
    const BallNormal average = average_normal(ball, 1, normal);
    BallFit out{frame_from_normal(round_normal(average.normal)), {}, {}, average.disagree};
    set_contrary_aside(ball, out.frame.normal, out.aside);
    if (edges != Edges::ignored && !holds_edge(ball, out)) enough = Enough::points;
    out.fit =
        forced ? fit_ball(ball, 1, out.frame, 1) : fit_ball(ball, 1, out.frame, degree, enough);
    for (int d = 2; forced && d <= degree && out.fit.sq_error > kWithinNoise * noise_variance; ++d)
        out.fit = fit_ball(ball, 1, out.frame, d);
    if (out.fit.fallback == Fallback::none && out.fit.degree < degree)
        out.fit.fallback = Fallback::lower_explains;
    return out;
}

CoveringSurfel cover_by(const PointTree& points, const Vec3d& center, const BallFit& ball_fit,
                        double noise_variance, Edges edges, Lists lists, BallPoints<double>& ball) {
    const LocalFit& fit = ball_fit.fit;
    CoveringSurfel out;
    const Footprint footprint = footprint_of(ball, ball_fit.frame);
    out.lean = footprint.lean;
    out.breadth = footprint.breadth;
    out.middle = footprint.middle;
    out.n_aside = ball_fit.aside.size();
    take_back(ball, ball_fit.frame.normal, ball_fit.aside);
    out.fitted.surfel = {center, ball.radius, ball_fit.frame, fit.polynomial, fit.degree};
    out.edges_are_real = edges == Edges::real;
    // the rims' axes are the file's
    if (out.edges_are_real) out.fitted.surfel = level_linear(out.fitted.surfel);
    out.fitted.fit_error = std::sqrt(fit.sq_error);
    out.fitted.n_points = static_cast<std::uint32_t>(fit.n_points);
    out.fallback = fit.fallback;
    out.normals_disagree = ball_fit.normals_disagree;
    if (out.edges_are_real) list_acute_edges(ball, ball_fit.aside, out);
    if (lists == Lists::made) list_points(points, ball, noise_variance, out);
    return out;
}

/// What is not drawn covers nothing: rims before a void have points beyond them (notes/0024).
void leave_out_beyond_rims(CoveringSurfel& leaf) {
    const PackedRims rims = leaf.fitted.surfel.rims;
    if (!rims.any()) return;
    const Rim first = unpack_rim(rims.first), second = unpack_rim(rims.second);
    const auto is_beyond = [](const Rim& rim, const Covered& p) {
        return rim.u * static_cast<double>(p.u) + rim.v * static_cast<double>(p.v) > rim.reach;
    };
    std::size_t n = 0;
    for (const Covered& p : leaf.covered)
        if (!is_beyond(first, p) && !is_beyond(second, p)) leaf.covered[n++] = p;
    leaf.covered.resize(n);
}

}  // namespace

CoveringSurfel fit_surfel(const PointTree& points, const Vec3d& center, const Vec3d& normal,
                          double radius, int degree, bool forced, double noise_variance,
                          BallPoints<double>& ball, Edges edges, Lists lists) {
    gather_ball(points, center, radius, ball);
    return fit_gathered_surfel(points, center, normal, degree, forced, noise_variance, ball, edges,
                               lists);
}

CoveringSurfel fit_gathered_surfel(const PointTree& points, const Vec3d& center,
                                   const Vec3d& normal, int degree, bool forced,
                                   double noise_variance, BallPoints<double>& ball, Edges edges,
                                   Lists lists) {
    const Enough enough = edges == Edges::ignored ? Enough::points : Enough::freedom;
    const BallFit fit = fit_gathered(normal, degree, forced, noise_variance, enough, edges, ball);
    return cover_by(points, center, fit, noise_variance, edges, lists, ball);
}

CoveringSurfel fit_steady_surfel(const PointPyramid& points, const Vec3d& center,
                                 const Vec3d& normal, double radius, int degree, bool forced,
                                 double noise_variance, SteadyWork& work, Lists lists) {
    gather_ball(points.all(), center, radius, work.ball);
    BallFit fit = fit_gathered(normal, degree, forced, noise_variance, Enough::freedom,
                               Edges::ignored, work.ball);
    fit.fit = steady_curvature(points, {center, fit.frame, work.ball, fit.fit}, degree,
                               noise_variance, work.wider);
    if (fit.fit.degree == degree) fit.fit.fallback = Fallback::none;
    return cover_by(points.all(), center, fit, noise_variance, Edges::ignored, lists, work.ball);
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
    list_points(points, ball, noise_variance, out);
    if (!out.explains_center) return std::nullopt;
    return out;
}

CoveringSurfel cover_again(const PointTree& points, const FittedSurfel& fitted,
                           double noise_variance, BallPoints<double>& ball,
                           const WantedOfBucket& wanted) {
    CoveringSurfel out;
    out.fitted = fitted;
    if (wanted)
        gather_wanted(points, fitted.surfel.center, fitted.surfel.support_radius, wanted, ball);
    else
        gather_ball(points, fitted.surfel.center, fitted.surfel.support_radius, ball);
    if (!fitted.surfel.sharp) {
        std::vector<SetAside<double>> aside;
        set_contrary_aside(ball, fitted.surfel.frame.normal, aside);
        take_back(ball, fitted.surfel.frame.normal, aside);
    }
    list_points(points, ball, noise_variance, out);
    leave_out_beyond_rims(out);
    return out;
}

}  // namespace slim
