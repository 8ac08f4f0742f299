#include "slim/smooth/local_noise.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/smooth/point_projector.h"
#include "slim/smooth/wide_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kGrain = 32;
constexpr double kOfQuartic = 75, kOfQuadratic = 24;  ///< points in a narrow disc
constexpr double kWiden = 1.3;
constexpr int kTries = 3;
constexpr double kQuiet = 0.2;        ///< of the points: in leaves of the least noise
constexpr double kMostOfQuiet = 9;    ///< times the squared noise that these have at most
constexpr std::size_t kMostPoints = 64;  ///< that are put on the surface, of a leaf
constexpr std::size_t kLeastPoints = 4;

/// Squared noise about a leaf's centre; nothing where no disc can be fitted.
std::optional<double> narrow_noise(const Surfel& s, double n_points, const PointTree& points, WideWork& work) {
    const Vec3d center = s.center + s.frame.normal * (s.polynomial.a[0] * s.support_radius);
    for (const double wanted : {kOfQuartic, kOfQuadratic}) {
        double radius = s.support_radius * std::sqrt(std::min(1.0, wanted / n_points));
        for (int i = 0; i < kTries && radius <= s.support_radius; ++i, radius *= kWiden)
            if (const auto fit = fit_wide(points, center, s.frame, radius, 0, wanted == kOfQuartic, work))
                return fit->sq_noise;
    }
    return std::nullopt;
}

/// The value that the quiet share of the weight lies below; infinite if there is none.
double quiet_noise(std::vector<std::pair<double, double>>& values) {
    std::sort(values.begin(), values.end());
    double left = 0;
    for (const auto& v : values) left += kQuiet * v.second;
    for (const auto& [value, weight] : values)
        if ((left -= weight) <= 0) return value;
    return INFINITY;
}

/// Mean square of how far a leaf's points go to the surface; nothing of too few.
std::optional<double> sq_displacement(const Surfel& s, const PointTree& points, PointProjector& projector,
                                      WideWork& work) {
    gather_ball(points, s.center, s.support_radius, work.ball);
    set_contrary_aside(work.ball, s.frame.normal, work.aside);
    const std::size_t stride = work.ball.n / kMostPoints + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < work.ball.n; i += stride) {
        if (!(work.ball.sq[i] < 1)) continue;
        const Vec3d x{work.ball.x[i], work.ball.y[i], work.ball.z[i]};
        const auto put = projector.project(s.center + x * work.ball.radius, Vec3d{});
        if (put.hit) sum += put.hit->t * put.hit->t, ++n;
    }
    if (n < kLeastPoints) return std::nullopt;
    return sum / static_cast<double>(n);
}

}  // namespace

std::vector<double> local_noise(const BallIndex& model, std::span<const LeafNoise> noise,
                                std::span<const WideRadius> radii, const PointPyramid& points) {
    const std::size_t n = model.n_leaves();
    SLIM_CHECK(radii.size(), ==, n);
    std::vector<double> own(n, INFINITY), out(n, INFINITY);
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        for (std::size_t i = begin; i < end; ++i) {
            const double in_ball = std::max(1.0, points.share(0) * noise[i].n_points);
            if (radii[i].radius > 0)
                own[i] = radii[i].sq_noise;
            else if (radii[i].in_cloud)
                own[i] = narrow_noise(model.leaf(i), in_ball, points.all(), work).value_or(INFINITY);
        }
    });
    std::vector<std::pair<double, double>> known;
    for (std::size_t i = 0; i < n; ++i)
        if (std::isfinite(own[i])) known.emplace_back(own[i], noise[i].n_points);
    const double most = kMostOfQuiet * quiet_noise(known);
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> around;
        for (std::size_t i = begin; i < end; ++i) {
            if (!radii[i].in_cloud) continue;
            model.supporters(model.leaf(i).center, around);
            double sum = 0, weight = 0;
            for (const Surfel* s : around)
                if (const double sq = own[model.number_of(s)]; std::isfinite(sq)) sum += std::min(sq, most), ++weight;
            out[i] = weight > 0 ? sum / weight : most;
        }
    });
    return out;
}

double trusted_share(double sq_displacement, double sq_noise) {
    if (!(sq_displacement > 2 * sq_noise)) return 1;
    return sq_noise / (sq_displacement - sq_noise);
}

std::vector<double> trusted_shares(const BallIndex& model, std::span<const WideRadius> radii,
                                   std::span<const double> sq_noise, const RefittedSurface& surface,
                                   const PointPyramid& points) {
    std::vector<double> out(model.n_leaves(), 1);
    parallel_blocks(out.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        PointProjector projector(surface.fits());
        for (std::size_t i = begin; i < end; ++i) {
            if (!std::isfinite(sq_noise[i])) continue;
            if (radii[i].radius > 0)
                out[i] = trusted_share(radii[i].sq_noise, sq_noise[i]);
            else if (const auto sq = sq_displacement(model.leaf(i), points.all(), projector, work))
                out[i] = trusted_share(*sq, sq_noise[i]);
        }
    });
    return out;
}

}  // namespace slim
