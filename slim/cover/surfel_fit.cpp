#include "slim/cover/surfel_fit.h"

#include "slim/model/surfel_tree.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr double kExplained = 4;  // residuals up to this many eps belong to the surfel

/// Lists the ball's points that the surfel explains; `at_center` is set if the centre's point is one.
void list_covered(const PointTree& tree, const BallPoints<double>& ball, double noise_variance,
                  CoveringSurfel& out) {
    const Surfel& s = out.fitted.surfel;
    const double tolerance =
        kExplained * std::max(out.fitted.fit_error, std::sqrt(noise_variance)) / s.support_radius;
    for (std::size_t i = 0; i < ball.n; ++i) {
        if (ball.sq[i] >= 1) continue;
        const Vec3d x = s.frame.local_from_world({ball.x[i], ball.y[i], ball.z[i]});
        if (!(std::abs(x.z - s.polynomial.value(x.x, x.y)) <= tolerance)) continue;
        out.covered.push_back({tree.source(ball.index[i]),
                               static_cast<float>(weight_kernel(ball.sq[i])),
                               ball.sq[i] < kTrim * kTrim});
        if (ball.sq[i] == 0) out.explains_center = true;
    }
}

}  // namespace

CoveringSurfel fit_surfel(const PointTree& points, const Vec3d& center, const Vec3d& normal,
                          double radius, int degree, double noise_variance,
                          BallPoints<double>& ball) {
    gather_ball(points, center, radius, ball);
    const BallNormal average = average_normal(ball, 1, normal);
    const Frame<double> frame = frame_from_normal(round_normal(average.normal));
    drop_other_side(ball, frame.normal);
    const LocalFit fit = fit_ball(ball, 1, frame, degree);

    CoveringSurfel out;
    out.fitted.surfel = {center, radius, frame, fit.polynomial, fit.degree};
    out.fitted.fit_error = std::sqrt(fit.sq_error);
    out.fitted.n_points = static_cast<std::uint32_t>(fit.n_points);
    out.fallback = fit.fallback;
    out.normals_disagree = average.disagree;
    list_covered(points, ball, noise_variance, out);
    return out;
}

}  // namespace slim
