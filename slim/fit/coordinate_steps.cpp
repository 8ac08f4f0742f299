#include "slim/fit/coordinate_steps.h"

#include "slim/base/frame.h"
#include "slim/normals/covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kFewNeighbors = 16, kManyNeighbors = 640, kNearNeighbors = 160;
constexpr std::size_t kThinner = 4, kMostOfThinned = 1 << 20;
/// Share of the samples whose few neighbours have a coordinate in common, from which many are
/// looked at.
constexpr double kSomeShare = 0.2;
/// Points that share a step, at least, in the mean: of a grid of points some 25 stand in a row of
/// 640.
constexpr std::size_t kPointsAStep = 8;
/// Steps that have so many, at least; and of the nearer points so many.
constexpr std::size_t kFewestSteps = 3, kNearPointsAStep = 2;
/// Squared cosine of an axis to the normal from which its steps lie along it.
constexpr double kAlong = 0.25;
/// Residual over step^2 / 12 of points that are rounded: 1, and more with noise, which hides steps
/// where it is larger; less of exact points on a grid, more where these have an edge.
constexpr double kLeastRounded = 0.4, kMostRounded = 10;
/// What the nearer neighbours leave of that, at least: rounding is the same at any size, what a
/// quadric misses of a surface soon nothing.
constexpr double kLeastNear = 0.25;
/// Samples that tell of steps, at least, their share of all, and the share of them that says that
/// steps are noise.
constexpr std::size_t kFewestTold = 16;
constexpr double kLeastShareTold = 1.0 / 16, kMostTold = 0.6;

/// The different values of a coordinate of some points.
struct Levels {
    std::vector<std::size_t> n_points;  ///< at each
    double extent = 0;

    std::size_t n() const { return n_points.size(); }
    /// Those that have so many points.
    std::size_t n_held(std::size_t least) const {
        return static_cast<std::size_t>(
            std::count_if(n_points.begin(), n_points.end(),
                          [&](std::size_t held) { return held >= least; }));
    }
};

Levels levels_of(std::span<const Vec3d> positions, std::span<const std::uint32_t> points,
                 std::size_t axis) {
    std::vector<double> x;
    x.reserve(points.size());
    for (const std::uint32_t i : points) x.push_back(positions[i][axis]);
    std::sort(x.begin(), x.end());
    Levels out;
    out.extent = x.back() - x.front();
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (i == 0 || x[i] != x[i - 1]) out.n_points.push_back(0);
        ++out.n_points.back();
    }
    return out;
}

/// Whether some points have a coordinate in common, pair by pair and more.
bool share_levels(std::span<const Vec3d> positions, std::span<const std::uint32_t> points) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (2 * levels_of(positions, points, axis).n() <= points.size()) return true;
    return false;
}

/// Squared steps of the axes along the normal of some points, where three steps and more are seen,
/// of the nearer ones, too; 0 where none are.
std::array<double, 3> sq_steps(std::span<const Vec3d> positions,
                               std::span<const std::uint32_t> points,
                               std::span<const std::uint32_t> nearer, const Vec3d& normal) {
    std::array<double, 3> out{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (normal[axis] * normal[axis] < kAlong) continue;
        const Levels levels = levels_of(positions, points, axis);
        if (levels.n_held(kPointsAStep) < kFewestSteps ||
            kPointsAStep * levels.n() > points.size() ||
            levels_of(positions, nearer, axis).n_held(kNearPointsAStep) < kFewestSteps)
            continue;
        const double step = levels.extent / static_cast<double>(levels.n() - 1);
        out[axis] = step * step;
    }
    return out;
}

/// Mean square of what a quadric over the plane across the normal leaves of some points, unbiased.
double quadric_residual(std::span<const Vec3d> positions, std::span<const std::uint32_t> points,
                        const Vec3d& normal, double reach) {
    using Vector = Eigen::Matrix<double, 6, 1>;
    const Frame<double> frame = frame_from_normal(normal);
    Eigen::Matrix<double, 6, 6> left = Eigen::Matrix<double, 6, 6>::Zero();
    Vector right = Vector::Zero();
    double sq = 0;
    for (const std::uint32_t i : points) {
        const Vec3d x = frame.local_from_world(positions[i] - positions[points[0]]) / reach;
        const Vector row{{1, x.x, x.y, x.x * x.x, x.x * x.y, x.y * x.y}};
        left += row * row.transpose();
        right += row * x.z;
        sq += x.z * x.z;
    }
    const double rest = sq - right.dot(left.ldlt().solve(right));
    const double n = static_cast<double>(points.size()) - 6;
    return n > 0 ? std::max(rest, 0.0) / n * reach * reach : 0;
}

/// Samples, rising, among every stride-th point.
std::vector<std::uint32_t> among(std::span<const std::uint32_t> samples, std::size_t stride) {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t i : samples) out.push_back(static_cast<std::uint32_t>(i / stride));
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

std::vector<Vec3d> every(std::size_t stride, std::span<const Vec3d> positions) {
    std::vector<Vec3d> out;
    out.reserve(positions.size() / stride + 1);
    for (std::size_t i = 0; i < positions.size(); i += stride) out.push_back(positions[i]);
    return out;
}

bool may_be_stepped(const NearestSearch& search, std::span<const std::uint32_t> wanted) {
    std::vector<std::uint8_t> shared(wanted.size());
    search.for_each(wanted, kFewNeighbors,
                    [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
                        shared[w] = share_levels(search.positions(), neighbors) ? 1 : 0;
                    });
    const auto n = static_cast<double>(std::count(shared.begin(), shared.end(), 1));
    return n > 0 && n >= kSomeShare * static_cast<double>(wanted.size());
}

/// The mean of n values with that of n_more added.
void add_mean(double& mean, std::size_t n, double more, std::size_t n_more) {
    if (n_more > 0)
        mean += static_cast<double>(n_more) / static_cast<double>(n + n_more) * (more - mean);
}

/// What is seen about one sample.
struct StepsSeen {
    std::array<double, 3> sq_step{};
    double variance = 0;  ///< that they make along the normal
    double residual = 0, near_residual = 0;  ///< squared, of all points off a quadric and of the
                                             ///< nearer ones off theirs

    bool are_rounded() const {
        return residual >= kLeastRounded * variance && residual <= kMostRounded * variance &&
               near_residual >= kLeastNear * residual;
    }
};

/// The nearer ones of some neighbours.
std::vector<std::uint32_t> nearer_of(std::span<const Vec3d> positions, std::uint32_t sample,
                                     std::span<const std::uint32_t> neighbors) {
    std::vector<std::uint32_t> out(neighbors.begin(), neighbors.end());
    const auto sq_far = [&](std::uint32_t i) {
        return sq_length(positions[i] - positions[sample]);
    };
    const auto end = out.begin() +
                     static_cast<std::ptrdiff_t>(std::min(kNearNeighbors, out.size() - 1));
    std::nth_element(out.begin(), end, out.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return sq_far(a) < sq_far(b); });
    out.erase(end, out.end());
    return out;
}

StepsSeen steps_seen(std::span<const Vec3d> positions, std::uint32_t sample,
                     std::span<const std::uint32_t> neighbors) {
    const Vec3d normal = spread_of(positions, neighbors).normal;
    const std::vector<std::uint32_t> nearer = nearer_of(positions, sample, neighbors);
    StepsSeen out{sq_steps(positions, neighbors, nearer, normal)};
    for (std::size_t axis = 0; axis < 3; ++axis)
        out.variance += normal[axis] * normal[axis] * out.sq_step[axis] / 12;
    if (!(out.variance > 0)) return out;
    const double reach = std::sqrt(sq_reach_of(positions, sample, neighbors));
    out.residual = quadric_residual(positions, neighbors, normal, reach);
    out.near_residual = quadric_residual(positions, nearer, normal, reach);
    return out;
}

/// What is seen about each of some points, added up.
CoordinateSteps steps_around(const NearestSearch& search, std::span<const std::uint32_t> wanted) {
    std::vector<StepsSeen> seen(wanted.size());
    search.for_each(wanted, kManyNeighbors,
                    [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
                        seen[w] = steps_seen(search.positions(), wanted[w], neighbors);
                    });
    CoordinateSteps out;
    out.n_sampled = wanted.size();
    for (const StepsSeen& s : seen) {  // in one order, so threads do not matter
        if (!(s.variance > 0)) continue;
        CoordinateSteps one{0, 1, s.are_rounded() ? 1u : 0u, s.variance,
                            std::max(s.variance, s.near_residual), {}};
        if (one.n_rounded > 0)
            for (std::size_t a = 0; a < 3; ++a)
                one.axes[a] = {s.sq_step[a] > 0 ? 1u : 0u, s.sq_step[a]};
        out += one;
    }
    return out;
}

}  // namespace

CoordinateSteps& CoordinateSteps::operator+=(const CoordinateSteps& other) {
    add_mean(variance, n_rounded, other.variance, other.n_rounded);
    add_mean(off, n_rounded, other.off, other.n_rounded);
    for (std::size_t a = 0; a < 3; ++a) {
        add_mean(axes[a].sq_step, axes[a].n, other.axes[a].sq_step, other.axes[a].n);
        axes[a].n += other.axes[a].n;
    }
    n_sampled += other.n_sampled, n_stepped += other.n_stepped, n_rounded += other.n_rounded;
    return *this;
}

bool CoordinateSteps::are_told() const {
    return static_cast<double>(n_stepped) >= kLeastShareTold * static_cast<double>(n_sampled);
}

bool CoordinateSteps::are_noise() const {
    return are_told() && n_stepped >= kFewestTold &&
           static_cast<double>(n_rounded) >= kMostTold * static_cast<double>(n_stepped);
}

double CoordinateSteps::noise_variance(const Vec3d& normal) const {
    if (!are_noise()) return 0;
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) sum += normal[a] * normal[a] * axes[a].sq_step;
    return sum / 12;
}

CoordinateSteps coordinate_steps(const NearestSearch& search,
                                 std::span<const std::uint32_t> samples) {
    const std::vector<std::uint32_t> wanted = among(samples, 1);
    CoordinateSteps out;
    out.n_sampled = wanted.size();
    if (search.size() < kManyNeighbors || !may_be_stepped(search, wanted)) return out;
    out = steps_around(search, wanted);
    for (std::size_t stride = kThinner; !out.are_told(); stride *= kThinner) {
        const std::size_t n = search.size() / stride;
        if (n < kManyNeighbors) break;
        if (n > kMostOfThinned) continue;
        const std::vector<Vec3d> fewer = every(stride, search.positions());
        out = steps_around(NearestSearch(fewer), among(samples, stride));
    }
    return out;
}

}  // namespace slim
