#include "slim/fit/edge_share.h"

#include "slim/base/parallel.h"
#include "slim/fit/local_fit.h"
#include "slim/fit/radius_ladder.h"
#include "slim/fit/sharp_clusters.h"
#include "slim/fit/sharp_filled.h"
#include "slim/fit/sharp_fit.h"
#include "slim/fit/sharp_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>

namespace slim {
namespace {

constexpr std::size_t kMost = 512, kRound = 32, kGrain = 4;
constexpr double kFewest = 500;       // points of a cloud that is asked
constexpr double kBall = 160;         // points of a ball ...
constexpr double kCloud = 8192;       // ... of a cloud thinned to so many
constexpr double kInNoise = 12;       // times sqrt(lambda): its least radius
constexpr double kMostWider = 3;      // times that of the ball: noise so thick leaves no place
constexpr double kMostInBall = 100;   // points that are looked at, after thinning
constexpr int kDegree = 2;            // of the height field that edges are told from
constexpr double kEven = 0.015;       // eps / rho: so little an edge of 30 degrees misses
constexpr double kLittleNoise = 0.03; // sqrt(lambda) / rho: up to it the groups of normals ...
constexpr double kStrict = 0.6;       // ... of an edge hold so much more of their spread
constexpr double kClearly = 1.5;      // times eps^2: two standard errors of some 30 points
constexpr double kBackToBack = -0.866;  // cosine of two sides of a plate or of a wing
constexpr double kSure = 99;          // to 1

/// The ball that is asked about, and the thinning that it is taken from.
struct Scale {
    double radius;
    std::size_t level;
};

/// Nothing where noise would make the ball so wide that it is no place but the shape as a whole, as
/// steps of the coordinates do where a small cloud lies far from the origin.
std::optional<Scale> scale_of(const PointPyramid& pyramid, const EdgeQuestion& cloud) {
    const double sq_spacing = cloud.spacing * cloud.spacing;
    const double area = kBall / std::min(kCloud, cloud.n_points) * cloud.n_points * sq_spacing;
    const double usual = std::sqrt(area / std::numbers::pi);
    Scale out{std::max(usual, kInNoise * std::sqrt(cloud.noise_variance)), 0};
    if (out.radius > kMostWider * usual) return {};
    const double n_in_ball = std::numbers::pi * out.radius * out.radius / sq_spacing;
    while (out.level + 1 < pyramid.n_levels() &&
           n_in_ball * pyramid.share(out.level) > kMostInBall)
        ++out.level;
    return out;
}

/// Workspace of one thread.
struct Work {
    BallPoints<float> ball;
    SharpWork<float> sharp;
};

bool are_back_to_back(const SharpFit& fit) {
    for (std::size_t a = 0; a < fit.n_sheets; ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (dot(fit.frame[a].normal, fit.frame[b].normal) < kBackToBack) return true;
    return false;
}

/// Whether so many sheets follow the ball's points, of which one height field leaves `sq_error`.
bool are_sheets(std::size_t n_sheets, double sq_error, const EdgeQuestion& cloud, Work& work) {
    const auto fit = fit_sharp(work.ball, n_sheets, kDegree, cloud.noise_variance, work.sharp);
    return fit && fit->sq_error <= sq_roughest(work.ball.radius, cloud.noise_variance) &&
           kClearly * fit->sq_error < sq_error &&
           within_noise(fit->n_off, work.ball.n, cloud.contrary_share) &&
           !are_back_to_back(*fit) && is_filled(*fit, work.ball, cloud.typical_variance);
}

bool is_at_edge(const Vec3d& center, const Vec3d& normal, const PointTree& tree, double radius,
                const EdgeQuestion& cloud, Work& work) {
    gather_ball(tree, center, radius, work.ball);
    const BallNormal side = average_normal(work.ball, 1.0, normal);
    const LocalFit smooth = fit_ball(work.ball, 1.0, frame_from_normal(side.normal), kDegree);
    if (smooth.sq_error < kEven * kEven * radius * radius) return false;
    const bool is_even = std::sqrt(cloud.noise_variance) < kLittleNoise * radius;
    if (!shows_edge(work.ball, is_even ? kStrict : 1)) return false;
    return are_sheets(2, smooth.sq_error, cloud, work) ||
           are_sheets(3, smooth.sq_error, cloud, work);
}

}  // namespace

double EdgeShare::evidence() const {
    const double yes = std::log(kManyEdges / kFewEdges),
                 no = std::log((1 - kManyEdges) / (1 - kFewEdges));
    return static_cast<double>(at_edges) * yes + static_cast<double>(asked - at_edges) * no;
}

EdgeShare edge_share(const PointBlock& points, const PointPyramid& pyramid,
                     const EdgeQuestion& cloud) {
    EdgeShare out;
    if (!(cloud.spacing > 0) || cloud.n_points < kFewest) return out;
    const std::optional<Scale> scale = scale_of(pyramid, cloud);
    if (!scale) return out;
    const std::size_t most = std::min(kMost, points.size());
    std::array<std::uint8_t, kRound> found{};
    while (out.asked < most && std::abs(out.evidence()) < std::log(kSure)) {
        const std::size_t first = out.asked, n = std::min(kRound, most - first);
        parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
            Work work;
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t p = pyramid.by_priority()[first + i];
                found[i] = is_at_edge(points.position[p], normalized(to_double(points.normal[p])),
                                      pyramid.level(scale->level), scale->radius, cloud, work);
            }
        });
        out.asked += n;
        for (std::size_t i = 0; i < n; ++i) out.at_edges += found[i];
    }
    return out;
}

}  // namespace slim
