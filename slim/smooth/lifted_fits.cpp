#include "slim/smooth/lifted_fits.h"

#include "slim/base/parallel.h"
#include "slim/model/weight_kernel.h"
#include "slim/tree/ball_index.h"

#include <cmath>

namespace slim {
namespace {

constexpr double kAround = 2.2;    ///< radii of the disc
constexpr double kLeastCos = 0.3;  ///< between the normals of fits that share a bias

/// Of a fit whose lift is known: over the fourth power of the radius, as a quartic's grows.
struct Share {
    double lift = 0, weight = 0;
};

/// The lifts of fits, and the balls in which they count.
class LiftField {
public:
    explicit LiftField(const std::vector<std::vector<PlacedFit>>& fits) : balls_(known(fits, share_)) {}

    /// The mean about a fit, for its radius.
    double at(const PlacedFit& fit, std::vector<const Surfel*>& found) const {
        balls_.supporters(fit.surfel.center, found);
        double sum = 0, all = 0;
        for (const Surfel* s : found) {
            if (!(dot(s->frame.normal, fit.surfel.frame.normal) > kLeastCos)) continue;
            const Share& share = share_[balls_.node(balls_.number_of(s))];
            const double sq = sq_length(s->center - fit.surfel.center) / (s->support_radius * s->support_radius);
            const double weight = share.weight * weight_kernel(sq);
            sum += weight * share.lift, all += weight;
        }
        return all > 0 ? sum / all * std::pow(fit.radius, 4) : 0;
    }

private:
    static std::vector<Surfel> known(const std::vector<std::vector<PlacedFit>>& fits, std::vector<Share>& share) {
        std::vector<Surfel> out;
        for (const auto& of_leaf : fits)
            for (const PlacedFit& f : of_leaf) {
                if (!(f.sq_lift_error > 0)) continue;
                const double fourth = std::pow(f.radius, 4);
                out.push_back(f.surfel);
                out.back().support_radius = kAround * f.radius;
                share.push_back({f.lift / fourth, fourth * fourth / f.sq_lift_error});
            }
        return out;
    }

    std::vector<Share> share_;
    BallIndex balls_;  // node(): the place in share_
};

}  // namespace

double height_by_noise_of_feet(const WideFit& fit, double radius) {
    const auto& a = fit.polynomial.a;
    return fit.sq_noise / fit.sq_stretch() * (a[3] + a[5]) / radius;
}

void lift_fits(std::vector<std::vector<PlacedFit>>& fits) {
    const LiftField field(fits);
    parallel_blocks(fits.size(), 4, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end; ++i)
            for (PlacedFit& f : fits[i]) {
                const double up = field.at(f, found) - f.spread_by_noise;
                f.surfel.polynomial.a[0] += up / f.surfel.support_radius;
            }
    });
}

}  // namespace slim
