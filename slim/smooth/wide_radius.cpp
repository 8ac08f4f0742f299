#include "slim/smooth/wide_radius.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/smooth/wide_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kGrain = 8;
constexpr double kTop = 0.25;      ///< of the diagonal: the widest rung
constexpr double kStep = 0.85;     ///< from rung to rung
constexpr std::size_t kRungs = 56; ///< down to 3e-5 of the diagonal
constexpr double kNarrowest = 0.4; ///< of a leaf's radius: less than its own fit uses
constexpr double kSearch = 8;      ///< of a leaf's radius: where points enough are looked for
constexpr double kNoises = 5;      ///< narrower discs than so many noises show noise alone
constexpr double kPlain = 8;       ///< times the variance: more squared bias ends the climb
constexpr double kMostPoints = 8192; ///< of a rung; more are thinned
constexpr double kGrowth = 3.67;   ///< of the squared bias from rung to rung, wherever it is not measured: kStep^-8
constexpr double kBiasFloor = 0.02; ///< of the variance
constexpr double kMostBeyond = 8;   ///< times the bias, or the variance, of leaves that have the rung
constexpr double kMostBias = 0.05;  ///< of the noise's variance; a leaf is kept where there is more
constexpr double kSameCloud = 0.5;  ///< of the points that a leaf was fitted to
constexpr double kKeep = 2;        ///< a leaf is kept where its variance alone is so many times less
constexpr int kParts = 4;          ///< of a step
constexpr int kRounds = 3;         ///< of means over the leaves around
constexpr double kShareUnderG = 0.25;  ///< of a ball's points: n_effective of a leaf's fit

/// A leaf's fits on the rungs [widest, narrowest] (rung 0 is the widest of all); the bias of wider ones is extrapolated.
struct Ladder {
    std::size_t widest = kRungs, narrowest = kRungs;  // kRungs: none
    std::array<float, kRungs> sq_bias{}, sq_error{}, sq_noise{};
    bool plain = false;  ///< the climb ended as the bias was plain: wider rungs have more
    bool has(std::size_t k) const { return widest <= k && k <= narrowest && widest < kRungs; }
};

double rung_radius(std::size_t k, double diagonal) { return kTop * diagonal * std::pow(kStep, k); }

bool is_plain(const Surfel& s) { return !s.sharp && !s.rims.any() && s.degree >= 1; }

/// Whether the cloud is the one that the leaf was fitted to, or as dense, and faces as it does: a refit to fewer
/// points would be worse, one to points whose normals are contrary finds another sheet's.
bool has_its_points(const Surfel& s, double n_points, const PointPyramid& points, WideWork& work) {
    const double wanted = kSameCloud * points.share(0) * n_points;
    gather_ball(points.all(), s.center, s.support_radius, work.ball);
    set_contrary_aside(work.ball, s.frame.normal, work.aside);
    return static_cast<double>(work.ball.n - work.aside.size()) >= std::max(1.0, wanted);
}

/// Climbs from the narrowest rung until the bias is plain.
Ladder climb(const Surfel& s, double noise, const PointPyramid& points, double diagonal, WideWork& work) {
    Ladder out;
    Frame<double> frame = s.frame;
    Vec3d center = s.center + s.frame.normal * (s.polynomial.a[0] * s.support_radius);
    std::size_t level = 0;
    for (std::size_t up = 0; up < kRungs; ++up) {
        const std::size_t k = kRungs - 1 - up;
        const double radius = rung_radius(k, diagonal);
        if (radius < std::max(kNarrowest * s.support_radius, kNoises * noise)) continue;
        const auto fit = fit_wide(points.level(level), center, frame, radius, noise, true, work);
        if (!fit) {
            if (out.has(k + 1) || radius > kSearch * s.support_radius) break;
            continue;
        }
        if (!(length(center + frame.normal * (fit->polynomial.a[0] * radius) - s.center) < s.support_radius)) break;
        if (out.widest == kRungs) out.narrowest = k;
        out.widest = k;
        // All points know it better than a thinning.
        out.sq_error[k] = static_cast<float>(fit->sq_error * points.share(level) / points.share(0));
        out.sq_bias[k] = static_cast<float>(fit->sq_bias);
        out.sq_noise[k] = static_cast<float>(fit->sq_noise);
        if (fit->sq_bias > kPlain * out.sq_error[k] + 3 * fit->sq_bias_error) {
            out.plain = true;
            break;
        }
        put_on(*fit, radius, noise, center, frame);
        if (fit->n / (kStep * kStep) > kMostPoints && level + 1 < points.n_levels()) ++level;
    }
    for (std::size_t k = out.widest; out.widest < kRungs && k-- > 0;)
        out.sq_bias[k] = std::max(out.sq_bias[k + 1], out.sq_error[out.widest]) * static_cast<float>(kGrowth);
    return out;
}

/// A rung's squared bias among leaves that overlap, of those that have the rung and of those whose climb ended below.
class PooledBias {
public:
    void add(const Ladder& l, std::size_t k) {
        if (l.has(k)) {
            sum_ += l.sq_bias[k], sq_error_ += l.sq_error[k], n_ += 1;
        } else if (l.plain && k < l.widest) {
            beyond_.push_back(l.sq_bias[k]);
        }
    }
    /// What was extrapolated counts for a few times what was measured at most: one climb that a stray ended would
    /// else say for all around how far they may go.
    double mean() const {
        double sum = sum_;
        const double most = n_ > 0 ? kMostBeyond * std::max(sum_, sq_error_) / n_ : INFINITY;
        for (const double b : beyond_) sum += std::min(b, most);
        const double n = n_ + static_cast<double>(beyond_.size());
        return n > 0 ? sum / n : 0;
    }
    void clear() { sum_ = sq_error_ = n_ = 0, beyond_.clear(); }

private:
    double sum_ = 0, sq_error_ = 0, n_ = 0;
    std::vector<double> beyond_;
};

/// The mean over a leaf, which counts twice, and those that hold its centre, of each rung's squared bias; kRounds times.
void pool(const BallIndex& model, std::vector<Ladder>& ladders) {
    std::vector<std::array<float, kRungs>> next(ladders.size());
    for (int round = 0; round < kRounds; ++round) {
        parallel_blocks(ladders.size(), 256, [&](std::size_t begin, std::size_t end) {
            std::vector<const Surfel*> around;
            PooledBias bias;
            for (std::size_t i = begin; i < end; ++i) {
                model.supporters(model.leaf(i).center, around);
                for (std::size_t k = 0; k < kRungs; ++k) {
                    bias.clear();
                    bias.add(ladders[i], k);
                    for (const Surfel* s : around) bias.add(ladders[model.number_of(s)], k);
                    next[i][k] = static_cast<float>(bias.mean());
                }
            }
        });
        for (std::size_t i = 0; i < ladders.size(); ++i) ladders[i].sq_bias = next[i];
    }
    // A wider rung knows its bias better.
    constexpr auto growth = static_cast<float>(kGrowth);
    for (Ladder& l : ladders)
        for (std::size_t k = 1; k < kRungs; ++k) l.sq_bias[k] = std::max(l.sq_bias[k], l.sq_bias[k - 1] / growth);
}

/// The radius of least error between rungs and on them; the logarithm of the bias goes straight from one to the next.
void choose_radius(const Ladder& ladder, const Surfel& s, const LeafNoise& noise, double diagonal, WideRadius& out) {
    double least = INFINITY, radius = 0, sq_noise = 0, bias = 0;
    const auto bias_at = [&](std::size_t k) { return std::max(kBiasFloor * ladder.sq_error[k], double{ladder.sq_bias[k]}); };
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
            least = sq, radius = rung_radius(k, diagonal) * std::pow(kStep, t);
            sq_noise = between(ladder.sq_noise[k], ladder.sq_noise[next]), bias = squared;
        }
    }
    const double of_leaf = std::max(sq_noise, noise.fit_error * noise.fit_error) * n_coefficients(s.degree) /
                           std::max(1.0, kShareUnderG * noise.n_points);
    if (least <= kKeep * of_leaf && bias <= kMostBias * sq_noise) out.radius = radius, out.sq_noise = sq_noise;
}

}  // namespace

std::vector<WideRadius> wide_radii(const BallIndex& model, std::span<const LeafNoise> noise,
                                   const PointPyramid& points, double diagonal, const EachBatch& each_batch) {
    const std::size_t n = model.n_leaves();
    SLIM_CHECK(noise.size(), ==, n);
    std::vector<Ladder> ladders(n);
    std::vector<WideRadius> out(n);
    parallel_batches(n, kGrain, each_batch, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        for (std::size_t i = begin; i < end; ++i) {
            const Surfel& s = model.leaf(i);
            out[i].in_cloud = has_its_points(s, noise[i].n_points, points, work);
            if (out[i].in_cloud && is_plain(s)) ladders[i] = climb(s, noise[i].fit_error, points, diagonal, work);
        }
    });
    pool(model, ladders);
    for (std::size_t i = 0; i < n; ++i) choose_radius(ladders[i], model.leaf(i), noise[i], diagonal, out[i]);
    return out;
}

std::vector<WideRadius> kept_radii(const BallIndex& model, std::span<const LeafNoise> noise, const PointPyramid& points) {
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
