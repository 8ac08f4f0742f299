#include "slim/cover/wider_balls.h"

#include "slim/cover/leaf_rim.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kTries = 4;
constexpr double kWellFitted = 0.06;  // eps / rho
constexpr std::size_t kFewSigns = 4;  // of an edge: single normals that noise turned
/// Of its weight: rims have 32 directions, and an edge between two of them must not count as air along its ends.
constexpr double kHardlyThere = 0.4;

}  // namespace

std::vector<float> wider_radii(const PointTree& points, const Vec3d& center, double least,
                               double most, std::size_t n_wanted, BallPoints<float>& work) {
    std::vector<float> out;
    gather_ball(points, center, least, work);
    const auto n_least = static_cast<double>(work.n);
    if (work.n == 0 || work.n >= n_wanted) return out;
    double radius = least;
    while (work.n <= n_wanted && radius < most) {
        radius = std::min(radius / kGoldenRatio, most);
        gather_ball(points, center, radius, work);
    }
    std::vector<float> sq(work.sq.begin(), work.sq.begin() + static_cast<std::ptrdiff_t>(work.n));
    std::sort(sq.begin(), sq.end());
    const auto n_most = static_cast<double>(std::min(n_wanted, sq.size()));
    for (int i = 0; i < kTries; ++i) {
        const double share = static_cast<double>(i) / kTries;
        const auto n =
            static_cast<std::size_t>(std::pow(n_most, 1 - share) * std::pow(n_least, share));
        const double reach = n < sq.size() ? std::sqrt(static_cast<double>(sq[n])) : 1;
        const auto wider = static_cast<float>(reach * radius);
        if (static_cast<double>(wider) > least && (out.empty() || wider < out.back()))
            out.push_back(wider);
    }
    return out;
}

bool is_well_fitted(const CoveringSurfel& leaf) {
    return leaf.explains_center && leaf.fitted.fit_error <= kWellFitted * leaf.fitted.surfel.support_radius;
}

bool shows_edge(const CoveringSurfel& leaf) { return leaf.edges.size() > kFewSigns || !leaf.edge_points.empty(); }

bool ends_before_air(const CoveringSurfel& leaf) {
    const PackedRims rims = rims_of(leaf);
    return std::none_of(leaf.air.begin(), leaf.air.end(), [&](const AirPlace& p) {
        return p.far && rim_share(rims, static_cast<double>(p.u), static_cast<double>(p.v)) > kHardlyThere;
    });
}

}  // namespace slim
