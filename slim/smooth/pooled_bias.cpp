#include "slim/smooth/pooled_bias.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slim {
namespace {

constexpr double kMostBeyond = 8;   ///< times the bias, or the variance, of
                                    ///< leaves that have the rung
constexpr int kRounds = 3;          ///< of means over the leaves around
constexpr double kAround = 3;       ///< radii: how far a bias may be shared
constexpr double kLeastCos = 0.3;   ///< between the normals of leaves that share
constexpr std::size_t kMostAsked = 256;  ///< leaves; of more, every so many

/// A rung's squared bias among leaves that overlap, of those that have the rung and of those whose
/// climb ended below.
class PooledBias {
public:
    void add(const BiasLadder& l, std::size_t k) {
        if (l.has(k)) {
            sum_ += l.sq_bias[k], sq_error_ += l.sq_error[k], n_ += 1;
        } else if (l.plain && k < l.widest) {
            beyond_.push_back(l.sq_bias[k]);
        }
    }
    /// What was extrapolated counts for a few times what was measured at most: one climb that a
    /// stray ended would else say for all around how far they may go.
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

/// What the lifts of leaves around a place have in common on a rung, and what they do not.
class SharedLift {
public:
    void add(double weight, double lift, double sq_error) {
        weight_ += weight, sq_weight_ += weight * weight;
        sum_ += weight * lift, sq_error_ += weight * weight * sq_error;
        sq_sum_ += weight * (lift * lift - sq_error);
    }
    /// Variance of the lifts beyond what noise gives them.
    double sq_unshared() const {
        const double mean = sum_ / weight_,
                     sq_mean = std::max(0.0, mean * mean - sq_error_ / (weight_ * weight_));
        const double n = weight_ * weight_ / sq_weight_;
        return std::max(0.0, sq_sum_ / weight_ - sq_mean) * n / std::max(1.0, n - 1);
    }

private:
    double weight_ = 0, sq_weight_ = 0, sum_ = 0, sq_error_ = 0, sq_sum_ = 0;
};

/// Of leaf i on a rung that it has.
double unshared(const BallIndex& model, std::span<const BiasLadder> ladders, std::size_t i,
                std::size_t k, double radius, std::vector<std::uint32_t>& around) {
    const Surfel& leaf = model.leaf(i);
    const Vec3d reach{radius, radius, radius};
    Bbox box;
    box.extend(leaf.center - reach), box.extend(leaf.center + reach);
    model.near(box, around);
    const std::size_t stride = (around.size() - 1) / kMostAsked + 1;
    SharedLift shared;
    shared.add(1, ladders[i].lift[k], ladders[i].sq_lift_error[k]);
    for (std::size_t a = 0; a < around.size(); a += stride) {
        const std::size_t j = around[a];
        const Surfel& other = model.leaf(j);
        if (j == i || !ladders[j].has(k) || dot(other.frame.normal, leaf.frame.normal) < kLeastCos)
            continue;
        const double weight =
            weight_kernel(sq_length(other.center - leaf.center) / (radius * radius));
        if (weight > 0) shared.add(weight, ladders[j].lift[k], ladders[j].sq_lift_error[k]);
    }
    return shared.sq_unshared();
}

}  // namespace

void pool_bias(const BallIndex& model, std::span<BiasLadder> ladders) {
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
    constexpr auto growth = static_cast<float>(kBiasGrowth);
    for (BiasLadder& l : ladders)
        for (std::size_t k = 1; k < kRungs; ++k)
            l.sq_bias[k] = std::max(l.sq_bias[k], l.sq_bias[k - 1] / growth);
}

std::vector<std::array<float, kRungs>> unshared_bias(
    const BallIndex& model, std::span<const BiasLadder> ladders, double diagonal,
    const std::function<bool(std::size_t leaf, std::size_t rung)>& is_asked) {
    SLIM_CHECK(ladders.size(), ==, model.n_leaves());
    std::vector<std::array<float, kRungs>> out(ladders.size());
    parallel_blocks(ladders.size(), 16, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> around;
        for (std::size_t i = begin; i < end; ++i) {
            out[i] = ladders[i].sq_bias;
            float wider = 0;  // a wider rung knows it better
            for (std::size_t k = 0; k < kRungs; ++k) {
                wider /= static_cast<float>(kBiasGrowth);
                if (!ladders[i].has(k) || !is_asked(i, k)) continue;
                const double own =
                    unshared(model, ladders, i, k, kAround * rung_radius(k, diagonal), around);
                wider = std::max(wider, std::min(static_cast<float>(own), ladders[i].sq_bias[k]));
                out[i][k] = wider;
            }
        }
    });
    return out;
}

}  // namespace slim
