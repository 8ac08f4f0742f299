#include "slim/smooth/lifted_fits.h"

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/model/weight_kernel.h"
#include "slim/tree/ball_index.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

namespace slim {
namespace {

constexpr double kAround = 2.2;    ///< radii of the disc
constexpr double kTurnNoise = 3;   ///< times the noise in turns: what is not believed of them
constexpr float kLeastCos = 0.3f;  ///< between the normals of fits that share a bias

/// The fits whose lift is known, by the balls in which it counts.
BallIndex balls_of(const std::vector<std::vector<PlacedFit>>& fits,
                   std::vector<const PlacedFit*>& known) {
    std::vector<Surfel> balls;
    for (const auto& of_leaf : fits)
        for (const PlacedFit& f : of_leaf) {
            if (!(f.sq_lift_error > 0)) continue;
            known.push_back(&f);
            balls.push_back(f.surfel);
            balls.back().support_radius = kAround * f.radius;
        }
    return BallIndex(std::move(balls));
}

/// What the fits about a place say of it.
struct Known {
    double lift = 0, turn_share = 0;
};

/// The fits whose balls meet a leaf's fits, side by side for lanes: centres from the leaf's first,
/// over its radius. One a thread.
class LiftsAround {
public:
    void gather(const BallIndex& balls, std::span<const PlacedFit* const> known,
                std::span<const PlacedFit> leaf) {
        Bbox box;
        for (const PlacedFit& f : leaf) box.extend(f.surfel.center);
        balls.near(box, near_);
        origin_ = leaf.front().surfel.center, unit_ = leaf.front().radius;
        const std::size_t n = near_.size(), padded = (n + kLanes - 1) / kLanes * kLanes;
        for (auto* column : {&x_, &y_, &z_, &nx_, &ny_, &nz_, &by_sq_radius_, &lift_, &weight_,
                             &sq_turn_, &sq_turn_error_})
            column->assign(padded, 0);
        importance_.resize(n);
        for (std::size_t i = 0; i < n; ++i)
            put(balls.leaf(near_[i]), *known[balls.node(near_[i])], i);
        // Over the most: the inverse of a variance that is next to nothing is no float.
        const double most = n > 0 ? *std::max_element(importance_.begin(), importance_.end()) : 1;
        for (std::size_t i = 0; i < n; ++i) weight_[i] = static_cast<float>(importance_[i] / most);
    }

    /// The weighted mean of lifts about a fit, for its radius, and what share of turns is not
    /// noise; zero if none is known.
    Known at(const PlacedFit& fit) const {
        const Vec3d place = (fit.surfel.center - origin_) / unit_, normal = fit.surfel.frame.normal;
        const auto lanes = [](double c) { return FloatV(static_cast<float>(c)); };
        const Vec3<FloatV> p{lanes(place.x), lanes(place.y), lanes(place.z)};
        const Vec3<FloatV> up{lanes(normal.x), lanes(normal.y), lanes(normal.z)};
        FloatV sum = 0, all = 0, turn = 0, noise = 0;
        for (std::size_t i = 0; i < x_.size(); i += kLanes) {
            const auto load = [i](const std::vector<float>& column) {
                return FloatV(&column[i], stdx::element_aligned);
            };
            const Vec3<FloatV> off{load(x_) - p.x, load(y_) - p.y, load(z_) - p.z};
            const FloatV sq = dot(off, off) * load(by_sq_radius_);
            const FloatV cosine = dot(Vec3<FloatV>{load(nx_), load(ny_), load(nz_)}, up);
            const FloatV near = load(weight_) * weight_kernel(sq);
            const FloatV weight = select<FloatV>(cosine > kLeastCos, near, FloatV(0));
            sum += weight * load(lift_), all += weight;
            turn += weight * load(sq_turn_), noise += weight * load(sq_turn_error_);
        }
        const double weight = stdx::reduce(all), sq_turn = stdx::reduce(turn);
        Known out;
        if (weight > 0)
            out.lift = stdx::reduce(sum) / weight * std::pow(fit.radius / unit_, 4) * unit_;
        if (sq_turn > 0)
            out.turn_share =
                std::max(0.0, 1 - kTurnNoise * static_cast<double>(stdx::reduce(noise)) / sq_turn);
        return out;
    }

private:
    /// A lift over the fourth power of the radius, as a quartic's grows,
    /// and the inverse of its variance.
    void put(const Surfel& ball, const PlacedFit& fit, std::size_t i) {
        const Vec3d c = (ball.center - origin_) / unit_, n = ball.frame.normal;
        const double sq = fit.radius * fit.radius / (unit_ * unit_), fourth = sq * sq,
                     reach = ball.support_radius / unit_;
        x_[i] = static_cast<float>(c.x), y_[i] = static_cast<float>(c.y),
        z_[i] = static_cast<float>(c.z);
        nx_[i] = static_cast<float>(n.x), ny_[i] = static_cast<float>(n.y),
        nz_[i] = static_cast<float>(n.z);
        by_sq_radius_[i] = static_cast<float>(1 / (reach * reach));
        lift_[i] = static_cast<float>(fit.lift / (unit_ * fourth));
        importance_[i] = fourth * fourth * unit_ * unit_ / fit.sq_lift_error;
        // A cubic's slope grows with the square of the radius.
        sq_turn_[i] =
            static_cast<float>((fit.turn[0] * fit.turn[0] + fit.turn[1] * fit.turn[1]) / fourth);
        sq_turn_error_[i] = static_cast<float>(fit.sq_turn_error / fourth);
    }

    std::vector<std::uint32_t> near_;
    std::vector<double> importance_;
    Vec3d origin_;
    double unit_ = 1;
    std::vector<float> x_, y_, z_, nx_, ny_, nz_, by_sq_radius_, lift_, weight_, sq_turn_,
        sq_turn_error_;
};

}  // namespace

double height_by_noise_of_feet(const WideFit& fit, double radius) {
    const auto& a = fit.polynomial.a;
    return fit.sq_noise / fit.sq_stretch() * (a[3] + a[5]) / radius;
}

void lift_fits(std::vector<std::vector<PlacedFit>>& fits) {
    std::vector<const PlacedFit*> known;
    const BallIndex balls = balls_of(fits, known);
    std::vector<std::vector<Known>> found(fits.size());
    parallel_blocks(fits.size(), 4, [&](std::size_t begin, std::size_t end) {
        LiftsAround around;
        for (std::size_t i = begin; i < end; ++i) {
            if (fits[i].empty()) continue;
            around.gather(balls, known, fits[i]);
            for (const PlacedFit& f : fits[i]) found[i].push_back(around.at(f));
        }
    });
    for (std::size_t i = 0; i < fits.size(); ++i)
        for (std::size_t j = 0; j < fits[i].size(); ++j) {
            PlacedFit& f = fits[i][j];
            auto& a = f.surfel.polynomial.a;
            a[0] += (found[i][j].lift - f.height_by_noise) / f.surfel.support_radius;
            for (std::size_t k = 0; k < 2; ++k) a[1 + k] += found[i][j].turn_share * f.turn[k];
        }
}

}  // namespace slim
