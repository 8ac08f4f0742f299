#include "slim/smooth/local_noise.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/smooth/disc_noise.h"
#include "slim/smooth/leaf_lanes.h"
#include "slim/smooth/point_projector.h"
#include "slim/smooth/wide_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace slim {
namespace {

constexpr std::size_t kGrain = 32;
constexpr double kAgrees =
    4;  ///< times the squared noise, which a disc tells within a half: a squared residual
constexpr std::size_t kMostPoints = 64;  ///< of a leaf, that are put on the surface
constexpr std::size_t kLeastPoints = 4;
constexpr double kKnown =
    300;  ///< points in a leaf's ball: its disc is so small a part that no edge fills it
constexpr double kQuiet = 0.2;  ///< of the leaves about one: those of the least noise
constexpr double kMostOfQuiet =
    4;  ///< times the squared noise of these that a leaf of fewer points has
constexpr std::size_t kAbout = 1000;  ///< leaves before one and after it, along the curve
constexpr double kFarOff = 4;         ///< of a point's noise: farther off, it goes less

Vec3d middle_of(const Surfel& s) {
    return s.center + s.frame.normal * (s.polynomial.a[0] * s.support_radius);
}

/// Squared noise about a leaf by itself, no less than that of rounded coordinates; infinite where
/// no disc can be fitted.
DiscNoise own_noise(const Surfel& s, const LeafNoise& leaf, const WideRadius& wide,
                    const PointPyramid& points, const CoordinateSteps& steps, WideWork& work) {
    const double n = std::max(1.0, points.share(0) * leaf.n_points);
    DiscNoise out = disc_noise(points.all(), middle_of(s), s.frame, s.support_radius, n,
                               leaf.fit_error, n < kKnown, work)
                        .value_or(DiscNoise{INFINITY});
    out.sq = std::max(out.sq, steps.noise_variance(s.frame.normal));
    if (wide.radius > 0 && wide.sq_noise <= kAgrees * out.sq) out.sq = wide.sq_noise;
    return out;
}

/// Puts points about a leaf on a surface, each along the surface's own normal.
class LeafProjector {
public:
    explicit LeafProjector(const BallIndex& surface) : surface_(surface), one_by_one_(surface) {}
    void gather(const Surfel& s) {
        const Vec3d reach{s.support_radius, s.support_radius, s.support_radius};
        lanes_.gather(surface_, {s.center - reach, s.center + reach});
    }
    /// How far a point of the leaf's ball goes, signed; nothing where the surface has no place for
    /// it.
    std::optional<double> displacement(const Vec3d& p) {
        if (const auto n = lanes_.are_plain() ? lanes_.normal_at(p) : std::nullopt)
            if (const auto put = lanes_.project_along(p, *n); put && dot(put->normal, *n) >= 0)
                return dot(put->point - p, *n);
        const ProjectedPoint put = one_by_one_.project(p, Vec3d{});
        return put.hit ? std::optional(put.hit->t) : std::nullopt;
    }

private:
    const BallIndex& surface_;
    LeafLanes lanes_;
    PointProjector one_by_one_;
};

/// Mean square of how far a leaf's points go to the surface; nothing of too few.
std::optional<double> sq_displacement(const Surfel& s, const PointTree& points,
                                      LeafProjector& projector, WideWork& work) {
    const BallPoints<float>& ball = work.ball;
    gather_ball(points, s.center, s.support_radius, work.ball);
    set_contrary_aside(work.ball, s.frame.normal, work.aside);
    projector.gather(s);
    const std::size_t stride = ball.n / kMostPoints + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < ball.n; i += stride) {
        if (!(ball.sq[i] < 1)) continue;
        const Vec3d x{ball.x[i], ball.y[i], ball.z[i]};
        if (const auto t = projector.displacement(s.center + x * ball.radius)) sum += *t * *t, ++n;
    }
    if (n < kLeastPoints) return std::nullopt;
    return sum / static_cast<double>(n);
}

/// Of each leaf, the noise that the quietest fifth of the leaves about it has: of those next along
/// the curve, the same for kTogether in a row. Cost: about 40 values a leaf.
std::vector<double> quiet_noise(std::span<const double> sq_noise) {
    constexpr std::size_t kTogether = 64;
    const std::size_t n = sq_noise.size();
    std::vector<double> out(n, INFINITY);
    parallel_blocks((n + kTogether - 1) / kTogether, 1, [&](std::size_t begin, std::size_t end) {
        std::vector<double> values;
        for (std::size_t group = begin; group < end; ++group) {
            const std::size_t first = group * kTogether, last = std::min(n, first + kTogether);
            values.clear();
            for (std::size_t k = first > kAbout ? first - kAbout : 0;
                 k < std::min(n, last + kAbout); ++k)
                if (std::isfinite(sq_noise[k])) values.push_back(sq_noise[k]);
            if (values.empty()) continue;
            const auto quiet = values.begin() + static_cast<std::ptrdiff_t>(
                                                    kQuiet * static_cast<double>(values.size()));
            std::nth_element(values.begin(), quiet, values.end());
            std::fill(out.begin() + static_cast<std::ptrdiff_t>(first),
                      out.begin() + static_cast<std::ptrdiff_t>(last), *quiet);
        }
    });
    return out;
}

}  // namespace

std::vector<double> local_noise(const BallIndex& model, std::span<const LeafNoise> noise,
                                std::span<const WideRadius> radii, const PointPyramid& points,
                                const CoordinateSteps& steps) {
    const std::size_t n = model.n_leaves();
    SLIM_CHECK(radii.size(), ==, n);
    std::vector<double> own(n, INFINITY), out(n, INFINITY);
    std::vector<std::uint8_t> plain(n);
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        for (std::size_t i = begin; i < end; ++i)
            if (radii[i].in_cloud) {
                const DiscNoise d =
                    own_noise(model.leaf(i), noise[i], radii[i], points, steps, work);
                own[i] = d.sq, plain[i] = d.plain;
            }
    });
    const std::vector<double> quiet = quiet_noise(own);
    for (std::size_t i = 0; i < n; ++i) {
        if (points.share(0) * noise[i].n_points < kKnown && !plain[i])
            own[i] = std::min(own[i], kMostOfQuiet * quiet[i]);
        own[i] = std::max(own[i], steps.noise_variance(model.leaf(i).frame.normal));
    }
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> around;
        std::vector<double> values;
        for (std::size_t i = begin; i < end; ++i) {
            if (!radii[i].in_cloud) continue;
            model.supporters(middle_of(model.leaf(i)), around);
            values.clear();
            for (const Surfel* s : around)
                if (const double sq = own[model.number_of(s)]; std::isfinite(sq))
                    values.push_back(sq);
            if (values.empty()) continue;
            const auto middle =
                values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
            std::nth_element(values.begin(), middle, values.end());
            out[i] = *middle;
        }
    });
    return out;
}

double trusted_share(double sq_bias, double sq_noise) {
    return sq_bias > sq_noise ? sq_noise / sq_bias : 1;
}

std::vector<LeafTrust> leaf_trust(const BallIndex& model, std::span<const WideRadius> radii,
                                  std::span<const double> sq_noise, const BallIndex& surface,
                                  const PointPyramid& points) {
    SLIM_CHECK(radii.size(), ==, model.n_leaves());
    SLIM_CHECK(sq_noise.size(), ==, model.n_leaves());
    std::vector<LeafTrust> out(model.n_leaves());
    parallel_blocks(out.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        LeafProjector projector(surface);
        for (std::size_t i = begin; i < end; ++i) {
            if (!std::isfinite(sq_noise[i])) continue;
            if (radii[i].radius > 0 && radii[i].sq_noise <= kAgrees * sq_noise[i]) continue;
            const auto sq = sq_displacement(model.leaf(i), points.all(), projector, work);
            if (!sq) {
                out[i].sq_noise = static_cast<float>(sq_noise[i]);
                continue;
            }
            const double share = trusted_share(*sq - sq_noise[i], sq_noise[i]);
            if (share < 1 || !(radii[i].radius > 0))
                out[i] = {static_cast<float>(share), static_cast<float>(sq_noise[i])};
        }
    });
    return out;
}

void PointTrust::add(const LeafTrust& leaf, double weight) {
    if (!(weight > 0)) return;
    const double sq_most = kFarOff * kFarOff * leaf.sq_noise;
    const double within =
        sq_distance_ > sq_most ? (sq_most / sq_distance_) * (sq_most / sq_distance_) : 1;
    sum_ += weight * within * leaf.share, weight_ += weight;
}

}  // namespace slim
