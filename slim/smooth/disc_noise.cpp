#include "slim/smooth/disc_noise.h"

#include "slim/base/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kOfQuartic = 75, kOfQuadratic = 24;  ///< points in a narrow disc
constexpr double kWiden = 1.3;
constexpr int kTries = 3;
constexpr double kThick = 4;               ///< of the noise: no disc is narrower
constexpr std::size_t kNeighbors = 6;      ///< that a plane goes through
constexpr std::size_t kMostSeeds = 48;     ///< points that are compared with their neighbours
constexpr std::size_t kLeastSeeds = 12;
constexpr double kMostLeverage = 1;        ///< of a plane's height at its middle: no point is judged from one side
constexpr double kMedianOfSquare = 0.4549; ///< of a unit normal

/// Height at the origin of the plane through points, and its variance for unit noise.
struct MiddleOfPlane {
    double height = 0, variance = INFINITY;
};

/// Sums over points, for a plane through them.
class PlaneSums {
public:
    void add(double u, double v, double h) {
        n_ += 1, u_ += u, v_ += v, uu_ += u * u, uv_ += u * v, vv_ += v * v;
        h_ += h, uh_ += u * h, vh_ += v * h;
    }
    MiddleOfPlane at_origin() const {
        const double c0 = uu_ * vv_ - uv_ * uv_, c1 = uv_ * v_ - u_ * vv_, c2 = u_ * uv_ - uu_ * v_;
        const double determinant = n_ * c0 + u_ * c1 + v_ * c2;
        if (!(determinant > 1e-6 * n_ * uu_ * vv_)) return {};
        return {(c0 * h_ + c1 * uh_ + c2 * vh_) / determinant, c0 / determinant};
    }

private:
    double n_ = 0, u_ = 0, v_ = 0, uu_ = 0, uv_ = 0, vv_ = 0, h_ = 0, uh_ = 0, vh_ = 0;
};

/// The points of a ball that count, in a frame, coordinates over the ball's radius.
struct DiscPoints {
    std::vector<double> u, v, height;
};

DiscPoints in_frame(const BallPoints<float>& ball, const Frame<double>& frame) {
    DiscPoints out;
    for (std::size_t i = 0; i < ball.n; ++i) {
        if (!(ball.sq[i] < 1)) continue;
        const Vec3d x = frame.local_from_world(Vec3d{ball.x[i], ball.y[i], ball.z[i]});
        out.u.push_back(x.x), out.v.push_back(x.y), out.height.push_back(x.z);
    }
    return out;
}

/// Least of the fit's own residual and of what the pseudo-residuals say.
double least_noise(const WideFit& fit, const WideWork& work, const Frame<double>& frame) {
    DiscPoints disc = in_frame(work.ball, frame);
    const double sq_unit = work.ball.radius * work.ball.radius;
    double least = fit.sq_noise;
    const auto take = [&] {
        if (const auto sq = pseudo_residual_noise(disc.u, disc.v, disc.height)) least = std::min(least, *sq * sq_unit);
    };
    take();
    for (std::size_t i = 0; i < disc.u.size(); ++i) disc.height[i] -= fit.polynomial.value(disc.u[i], disc.v[i]);
    take();
    return std::max(least, fit.sq_rounding);
}

}  // namespace

std::optional<double> pseudo_residual_noise(std::span<const double> u, std::span<const double> v,
                                            std::span<const double> height) {
    SLIM_CHECK(u.size(), ==, height.size());
    SLIM_CHECK(v.size(), ==, height.size());
    if (u.size() < kLeastSeeds) return std::nullopt;
    std::vector<std::pair<double, std::size_t>> near(u.size());
    std::vector<double> squares;
    const std::size_t stride = (u.size() - 1) / kMostSeeds + 1;
    for (std::size_t i = 0; i < u.size(); i += stride) {
        for (std::size_t k = 0; k < u.size(); ++k)
            near[k] = {k == i ? -1 : std::pow(u[k] - u[i], 2) + std::pow(v[k] - v[i], 2), k};
        std::nth_element(near.begin(), near.begin() + kNeighbors, near.end());
        PlaneSums sums;
        for (std::size_t k = 0; k <= kNeighbors; ++k)
            if (const std::size_t j = near[k].second; j != i) sums.add(u[j] - u[i], v[j] - v[i], height[j] - height[i]);
        const MiddleOfPlane plane = sums.at_origin();
        if (plane.variance <= kMostLeverage) squares.push_back(plane.height * plane.height / (1 + plane.variance));
    }
    if (squares.size() < kLeastSeeds) return std::nullopt;
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return *middle / kMedianOfSquare;
}

std::optional<double> disc_noise(const PointTree& points, const Vec3d& center, const Frame<double>& frame, double radius,
                                 double n_points, double noise, WideWork& work) {
    for (const double wanted : {kOfQuartic, kOfQuadratic}) {
        double narrow = std::min(radius, std::max(kThick * noise, radius * std::sqrt(wanted / n_points)));
        for (int i = 0; i < kTries && narrow <= radius; ++i, narrow *= kWiden)
            if (const auto fit = fit_wide(points, center, frame, narrow, noise, wanted == kOfQuartic, work))
                return least_noise(*fit, work, frame);
    }
    return std::nullopt;
}

}  // namespace slim
