#include "slim/smooth/wide_radius.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/smooth/bias_ladder.h"
#include "slim/smooth/pooled_bias.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kGrain = 8;
constexpr double kTakenOff = 0.03; ///< of the squared bias: what is left of it at least once
                                   ///< neighbours' mean is taken off
constexpr double kUnshared = 1.5;  ///< times what neighbours do not share
constexpr double kBiasFloor = 0.02; ///< of the variance
constexpr double kMostBias = 0.05;  ///< of the noise's variance; a leaf is kept where there is more
constexpr double kSameCloud = 0.5;  ///< of the points that a leaf was fitted to
constexpr double kKeep = 2;        ///< a leaf is kept where its variance
                                   ///< alone is so many times less
constexpr int kParts = 4;          ///< of a step
constexpr double kShareUnderG = 0.25;  ///< of a ball's points: n_effective of a leaf's fit

bool is_plain(const Surfel& s) { return !s.sharp && !s.rims.any() && s.degree >= 1; }

/// Whether the cloud is the one that the leaf was fitted to, or as dense, and faces as it does: a
/// refit to fewer points would be worse, one to points whose normals are contrary finds another
/// sheet's.
bool has_its_points(const Surfel& s, double n_points, const PointPyramid& points, WideWork& work) {
    const double wanted = kSameCloud * points.share(0) * n_points;
    gather_ball(points.all(), s.center, s.support_radius, work.ball);
    set_contrary_aside(work.ball, s.frame.normal, work.aside);
    return static_cast<double>(work.ball.n - work.aside.size()) >= std::max(1.0, wanted);
}

/// Variance of the middle of the leaf's own fit, for noise as a wide one sees it.
double sq_error_of_leaf(const Surfel& s, const LeafNoise& noise, double sq_noise) {
    return std::max(sq_noise, noise.fit_error * noise.fit_error) * n_coefficients(s.degree) /
           std::max(1.0, kShareUnderG * noise.n_points);
}

/// Squared bias of a rung: what cannot be taken off, or what neighbours do not share.
double bias_left(const BiasLadder& ladder, std::size_t k, double unshared) {
    return std::max(
        {kBiasFloor * ladder.sq_error[k], kTakenOff * ladder.sq_bias[k], kUnshared * unshared});
}

/// Whether a leaf may be fitted anew on a rung if neighbours share all of its bias (of a clean
/// cloud's few may), and what they do not share may count there.
bool may_be_chosen(const BiasLadder& ladder, std::size_t k, const Surfel& s,
                   const LeafNoise& noise) {
    const double bias = bias_left(ladder, k, 0), most = kUnshared * ladder.sq_bias[k];
    return bias < most && bias <= kMostBias * ladder.sq_noise[k] &&
           ladder.sq_error[k] <= kKeep * sq_error_of_leaf(s, noise, ladder.sq_noise[k]);
}

/// The radius of least error between rungs and on them; the logarithm of the bias goes straight
/// from one to the next.
void choose_radius(const BiasLadder& ladder, const std::array<float, kRungs>& unshared,
                   const Surfel& s, const LeafNoise& noise, double diagonal, WideRadius& out) {
    double least = INFINITY, radius = 0, sq_noise = 0, bias = 0;
    const auto bias_at = [&](std::size_t k) { return bias_left(ladder, k, unshared[k]); };
    for (std::size_t k = 0; k < kRungs; ++k) {
        if (!ladder.has(k)) continue;
        for (int part = 0; part < kParts; ++part) {
            const double t = static_cast<double>(part) / kParts;
            if (part > 0 && !ladder.has(k + 1)) break;
            const std::size_t next = k + (part > 0 ? 1 : 0);
            const auto between = [&](double a, double b) {
                return a > 0 && b > 0 ? a * std::pow(b / a, t) : a + (b - a) * t;
            };
            const double squared = between(bias_at(k), bias_at(next));
            const double sq = between(ladder.sq_error[k], ladder.sq_error[next]) + squared;
            if (!(sq < least)) continue;
            least = sq, radius = rung_radius(k, diagonal) * std::pow(kRungStep, t);
            sq_noise = between(ladder.sq_noise[k], ladder.sq_noise[next]), bias = squared;
        }
    }
    if (least <= kKeep * sq_error_of_leaf(s, noise, sq_noise) && bias <= kMostBias * sq_noise)
        out.radius = radius, out.sq_noise = sq_noise;
}

}  // namespace

std::vector<WideRadius> wide_radii(const BallIndex& model, std::span<const LeafNoise> noise,
                                   const PointPyramid& points, double diagonal,
                                   const EachBatch& each_batch) {
    const std::size_t n = model.n_leaves();
    SLIM_CHECK(noise.size(), ==, n);
    std::vector<BiasLadder> ladders(n);
    std::vector<WideRadius> out(n);
    parallel_batches(n, kGrain, each_batch, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        for (std::size_t i = begin; i < end; ++i) {
            const Surfel& s = model.leaf(i);
            out[i].in_cloud = has_its_points(s, noise[i].n_points, points, work);
            if (out[i].in_cloud && is_plain(s))
                ladders[i] = climb_ladder(s, noise[i].fit_error, points, diagonal, work);
        }
    });
    pool_bias(model, ladders);
    const auto unshared =
        unshared_bias(model, ladders, diagonal, [&](std::size_t i, std::size_t k) {
            return may_be_chosen(ladders[i], k, model.leaf(i), noise[i]);
        });
    for (std::size_t i = 0; i < n; ++i)
        choose_radius(ladders[i], unshared[i], model.leaf(i), noise[i], diagonal, out[i]);
    return out;
}

std::vector<WideRadius> kept_radii(const BallIndex& model, std::span<const LeafNoise> noise,
                                   const PointPyramid& points) {
    const std::size_t n = model.n_leaves();
    SLIM_CHECK(noise.size(), ==, n);
    std::vector<WideRadius> out(n);
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        for (std::size_t i = begin; i < end; ++i)
            out[i].in_cloud = has_its_points(model.leaf(i), noise[i].n_points, points, work);
    });
    return out;
}

}  // namespace slim
