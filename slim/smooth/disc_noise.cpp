#include "slim/smooth/disc_noise.h"

#include "slim/base/check.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kOfQuartic = 75, kOfQuadratic = 24;  ///< points in a narrow disc
constexpr double kWiden = 1.3;
constexpr int kTries = 3;
constexpr double kThick = 4;            ///< of the noise: no disc is narrower
constexpr std::size_t kNeighbors = 6;   ///< that a plane goes through
constexpr std::size_t kMostSeeds = 48;  ///< points that are compared with their neighbours
constexpr std::size_t kLeastSeeds = 12;
/// Of a plane's height at its middle: no point is judged from one side.
constexpr double kMostLeverage = 1;
constexpr double kNearlyOnLine = 0.05;  ///< of the variance along a line: that across
constexpr double kAgree = 6;  ///< times the least squared noise of all that is asked for: the most
constexpr double kMedianOfSquare = 0.4549;  ///< of a unit normal

/// Height at the origin of the plane through points, and its variance for unit noise.
struct MiddleOfPlane {
    double height = 0, variance = INFINITY;
    bool on_line = false;  ///< they lie nearly on one, which serves instead
};

/// Sums over points, for a plane through them.
class PlaneSums {
public:
    void add(double u, double v, double h) {
        n_ += 1, u_ += u, v_ += v, uu_ += u * u, uv_ += u * v, vv_ += v * v;
        h_ += h, uh_ += u * h, vh_ += v * h;
    }
    /// Of points nearly on a line of the frame's plane that of a line through them, level across:
    /// the plane would be as steep as noise, which is not quite upright in the frame, tells.
    MiddleOfPlane at_origin() const {
        const double u = u_ / n_, v = v_ / n_, h = h_ / n_;
        const double uu = uu_ / n_ - u * u, uv = uv_ / n_ - u * v, vv = vv_ / n_ - v * v;
        const double uh = uh_ / n_ - u * h, vh = vh_ / n_ - v * h;
        const double determinant = uu * vv - uv * uv, trace = uu + vv;
        if (!(trace > 0)) return {};
        constexpr double kOnLine = kNearlyOnLine / ((1 + kNearlyOnLine) * (1 + kNearlyOnLine));
        if (determinant < kOnLine * trace * trace) {
            // Along the eigenvector of the larger variance.
            const double along = trace / 2 + std::hypot((uu - vv) / 2, uv);
            const double x = uu > vv ? along - vv : uv, y = uu > vv ? uv : along - uu;
            const double sq = x * x + y * y, to = -(x * u + y * v),
                         slope = (x * uh + y * vh) / along;
            return {h + slope * to / sq, (1 + to * to / (along * sq)) / n_, true};
        }
        const double to_u = (vv * u - uv * v) / determinant, to_v = (uu * v - uv * u) / determinant;
        return {h - to_u * uh - to_v * vh, (1 + to_u * u + to_v * v) / n_};
    }

private:
    double n_ = 0, u_ = 0, v_ = 0, uu_ = 0, uv_ = 0, vv_ = 0, h_ = 0, uh_ = 0, vh_ = 0;
};

/// The points of a ball that count, each place once (copies of a point tell nothing of its noise),
/// in a frame, coordinates over the ball's radius.
struct DiscPoints {
    std::vector<double> u, v, height;
    std::vector<Vec3d> normal;  // in the frame; zero: none
};

DiscPoints in_frame(const BallPoints<float>& ball, const Frame<double>& frame) {
    const auto place = [&ball](std::size_t i) {
        return std::array{ball.x[i], ball.y[i], ball.z[i]};
    };
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < ball.n; ++i)
        if (ball.sq[i] < 1) order.push_back(i);
    std::sort(order.begin(), order.end(),
              [&](auto a, auto b) { return std::pair(place(a), a) < std::pair(place(b), b); });
    DiscPoints out;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::size_t i = order[k];
        if (k > 0 && place(i) == place(order[k - 1])) continue;
        const Vec3d x = frame.local_from_world(Vec3d{ball.x[i], ball.y[i], ball.z[i]});
        out.u.push_back(x.x), out.v.push_back(x.y), out.height.push_back(x.z);
        out.normal.push_back(frame.local_from_world(Vec3d{ball.nx[i], ball.ny[i], ball.nz[i]}));
    }
    return out;
}

double sq_between(std::span<const double> u, std::span<const double> v, std::size_t i,
                  std::size_t k) {
    return (u[k] - u[i]) * (u[k] - u[i]) + (v[k] - v[i]) * (v[k] - v[i]);
}

/// Median over that of a unit normal's square; nothing of few.
std::optional<double> robust_mean(std::vector<double>& squares) {
    if (squares.size() < kLeastSeeds) return std::nullopt;
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return *middle / kMedianOfSquare;
}

/// Of points and the nearest to each: how far one is off the plane through the other that is normal
/// to the mean of their normals. On an arc that is nothing, however wide apart they are; wrong
/// normals add to it. Nothing without normals.
std::optional<double> arc_noise(const DiscPoints& disc) {
    std::vector<double> squares;
    const std::size_t n = disc.u.size(), stride = (n + kMostSeeds - 1) / kMostSeeds;
    for (std::size_t i = 0; i < n; i += stride) {
        std::size_t near = i == 0 ? n - 1 : 0;
        for (std::size_t k = 0; k < n; ++k)
            if (k != i && sq_between(disc.u, disc.v, i, k) < sq_between(disc.u, disc.v, i, near))
                near = k;
        const Vec3d sum = disc.normal[i] + disc.normal[near];
        if (!(sq_length(disc.normal[i]) > 0 && sq_length(disc.normal[near]) > 0 &&
              sq_length(sum) > 0))
            continue;
        const Vec3d chord{disc.u[near] - disc.u[i], disc.v[near] - disc.v[i],
                          disc.height[near] - disc.height[i]};
        const double off = dot(chord, normalized(sum));
        squares.push_back(off * off / 2);
    }
    return robust_mean(squares);
}

/// A point and the nearest to it by feet.
struct Seed {
    std::size_t point;
    std::array<std::size_t, kNeighbors> near;
};

/// The nearest to a place of points that were shown, of equally near ones the first.
class NearestFew {
public:
    double farthest() const { return sq_.back(); }
    /// A point nearer than the farthest.
    void add(double sq, std::size_t point) {
        std::size_t at = kNeighbors - 1;
        for (; at > 0 && sq < sq_[at - 1]; --at) sq_[at] = sq_[at - 1], point_[at] = point_[at - 1];
        sq_[at] = sq, point_[at] = point;
    }
    const std::array<std::size_t, kNeighbors>& points() const { return point_; }

private:
    std::array<double, kNeighbors> sq_ = filled();
    std::array<std::size_t, kNeighbors> point_{};

    static std::array<double, kNeighbors> filled() {
        std::array<double, kNeighbors> sq;
        sq.fill(INFINITY);
        return sq;
    }
};

/// The nearest to the i-th point but itself. By lanes: few of them are nearer than what is found
/// already.
std::array<std::size_t, kNeighbors> nearest_to(std::span<const double> u, std::span<const double> v,
                                               std::size_t i) {
    using V = stdx::native_simd<double>;
    NearestFew found;
    const V at_u(u[i]), at_v(v[i]);
    const auto show = [&](std::size_t k, double sq) {
        if (k != i && sq < found.farthest()) found.add(sq, k);
    };
    std::size_t k = 0;
    for (; k + V::size() <= u.size(); k += V::size()) {
        const V du = V(&u[k], stdx::element_aligned) - at_u,
                dv = V(&v[k], stdx::element_aligned) - at_v;
        const V sq = du * du + dv * dv;
        for (std::uint64_t bits = lane_bits(sq < found.farthest()); bits != 0; bits &= bits - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
            show(k + lane, sq[lane]);
        }
    }
    for (; k < u.size(); ++k) show(k, sq_between(u, v, i, k));
    return found.points();
}

/// Evenly many of the points, each with its neighbours. Cost: O(seeds points).
std::vector<Seed> seeds_of(std::span<const double> u, std::span<const double> v) {
    std::vector<Seed> seeds;
    if (u.size() < kLeastSeeds) return seeds;
    const std::size_t stride = (u.size() - 1) / kMostSeeds + 1;
    seeds.reserve(u.size() / stride + 1);
    for (std::size_t i = 0; i < u.size(); i += stride) seeds.push_back({i, nearest_to(u, v, i)});
    return seeds;
}

/// What pseudo-residuals say.
struct PseudoResiduals {
    std::optional<double> sq_noise;
    bool on_lines = false;  ///< most points' neighbours lie on a line
};

PseudoResiduals noise_at(std::span<const Seed> seeds, std::span<const double> u,
                         std::span<const double> v, std::span<const double> height) {
    std::vector<double> squares;
    std::size_t on_line = 0;
    for (const Seed& seed : seeds) {
        const std::size_t i = seed.point;
        PlaneSums sums;
        for (const std::size_t j : seed.near)
            sums.add(u[j] - u[i], v[j] - v[i], height[j] - height[i]);
        const MiddleOfPlane plane = sums.at_origin();
        if (!(plane.variance <= kMostLeverage)) continue;
        squares.push_back(plane.height * plane.height / (1 + plane.variance));
        on_line += plane.on_line ? 1 : 0;
    }
    const bool on_lines = 2 * on_line > squares.size();
    return {robust_mean(squares), on_lines};
}

/// Least of the fit's own residual and of what the pseudo-residuals say. Where points lie on lines
/// the fit goes between few of them and follows the noise of each: its residual says nothing.
DiscNoise least_noise(const WideFit& fit, const WideWork& work, const Frame<double>& frame,
                      bool by_normals) {
    DiscPoints disc = in_frame(work.ball, frame);
    const double sq_unit = work.ball.radius * work.ball.radius;
    const std::vector<Seed> seeds = seeds_of(disc.u, disc.v);
    const PseudoResiduals whole = noise_at(seeds, disc.u, disc.v, disc.height);
    const bool by_fit = !(whole.sq_noise && whole.on_lines);
    double least = by_fit ? fit.sq_noise : INFINITY, most = by_fit ? fit.sq_noise : 0;
    const auto take = [&](std::optional<double> sq) {
        if (sq) least = std::min(least, *sq * sq_unit), most = std::max(most, *sq * sq_unit);
    };
    const std::optional<double> arcs = by_normals ? arc_noise(disc) : std::nullopt;
    take(arcs);
    take(whole.sq_noise);
    for (std::size_t i = 0; i < disc.u.size(); ++i)
        disc.height[i] -= fit.polynomial.value(disc.u[i], disc.v[i]);
    take(noise_at(seeds, disc.u, disc.v, disc.height).sq_noise);
    return {std::max(least, fit.sq_rounding), arcs && most <= kAgree * least};
}

}  // namespace

std::optional<double> pseudo_residual_noise(std::span<const double> u, std::span<const double> v,
                                            std::span<const double> height) {
    SLIM_CHECK(u.size(), ==, height.size());
    SLIM_CHECK(v.size(), ==, height.size());
    return noise_at(seeds_of(u, v), u, v, height).sq_noise;
}

std::optional<DiscNoise> disc_noise(const PointTree& points, const Vec3d& center,
                                    const Frame<double>& frame, double radius, double n_points,
                                    double noise, bool by_normals, WideWork& work) {
    for (const double wanted : {kOfQuartic, kOfQuadratic}) {
        double narrow =
            std::min(radius, std::max(kThick * noise, radius * std::sqrt(wanted / n_points)));
        for (int i = 0; i < kTries && narrow <= radius; ++i, narrow *= kWiden)
            if (const auto fit =
                    fit_wide(points, {center, frame, narrow, noise}, wanted == kOfQuartic, work))
                return least_noise(*fit, work, frame, by_normals);
    }
    return std::nullopt;
}

}  // namespace slim
