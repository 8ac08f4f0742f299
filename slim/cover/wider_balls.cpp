#include "slim/cover/wider_balls.h"

#include "slim/cover/leaf_rim.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kTries = 4;
// times as many points are gathered at first, if they are spread evenly
constexpr double kMoreThanWanted = 1.3;
constexpr double kWellFitted = 0.06;  // eps / rho
constexpr std::size_t kFewSigns = 4;  // of an edge: single normals that noise turned
/// Of its weight: rims have 32 directions, and an edge between two of them must not count as air
/// along its ends.
constexpr double kHardlyThere = 0.4;

}  // namespace

std::vector<float> wider_radii(const PointTree& points, const Vec3d& center, double least,
                               double most, std::size_t n_wanted, BallPoints<double>& ball) {
    std::vector<float> out;
    const std::size_t n_least = count_in_ball(points, center, least, n_wanted);
    if (n_least == 0 || n_least >= n_wanted) return out;
    const auto times = static_cast<double>(n_wanted) / static_cast<double>(n_least);
    double radius = std::min(least * std::sqrt(kMoreThanWanted * times), most);
    gather_ball(points, center, radius, ball);
    while (ball.n <= n_wanted && radius < most) {
        radius = std::min(radius / kGoldenRatio, most);
        gather_ball(points, center, radius, ball);
    }
    std::vector<double> sq(ball.sq.begin(), ball.sq.begin() + static_cast<std::ptrdiff_t>(ball.n));
    auto end = sq.end();  // before it: the nearest ones
    const auto n_most = static_cast<double>(std::min(n_wanted, sq.size()));
    for (int i = 0; i < kTries; ++i) {
        const double share = static_cast<double>(i) / kTries;
        const auto n = static_cast<std::ptrdiff_t>(std::pow(n_most, 1 - share) *
                                                   std::pow(static_cast<double>(n_least), share));
        const auto nth = sq.begin() + n;
        if (nth < end) std::nth_element(sq.begin(), nth, end), end = nth;
        const double reach = nth < sq.end() ? std::sqrt(*nth) : 1;
        const auto wider = static_cast<float>(reach * radius);
        if (static_cast<double>(wider) > least && (out.empty() || wider < out.back()))
            out.push_back(wider);
    }
    return out;
}

double share_sideways(const BallPoints<double>& ball, const Vec3d& normal) {
    std::size_t sideways = 0, away = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const double cosine = dot(normal, Vec3d{ball.nx[i], ball.ny[i], ball.nz[i]});
        if (cosine < kLeastCos) ++(cosine < kOtherSideCos ? away : sideways);
    }
    return static_cast<double>(sideways) /
           static_cast<double>(std::max<std::size_t>(ball.n - away, 1));
}

bool is_thin_enough(const CoveringSurfel& leaf) {
    return leaf.fitted.fit_error <= kWellFitted * leaf.fitted.surfel.support_radius;
}

bool is_well_fitted(const CoveringSurfel& leaf) {
    return leaf.explains_center && is_thin_enough(leaf);
}

bool has_edge_signs(const CoveringSurfel& leaf) {
    return leaf.edges.size() > kFewSigns || !leaf.edge_points.empty();
}

bool ends_before_air(const CoveringSurfel& leaf) {
    const auto is_far = [](const AirPlace& p) { return p.far; };
    const auto first = std::find_if(leaf.air.begin(), leaf.air.end(), is_far);
    if (first == leaf.air.end()) return true;  // as of most: their rims are not looked for
    const PackedRims rims = rims_of(leaf);
    return std::none_of(first, leaf.air.end(), [&](const AirPlace& p) {
        return is_far(p) &&
               rim_share(rims, static_cast<double>(p.u), static_cast<double>(p.v)) > kHardlyThere;
    });
}

}  // namespace slim
