#include "slim/smooth/coordinate_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kSample = 4096, kLeastPoints = 64;
constexpr double kSame = 1e-12;       ///< of the extent: what two equal coordinates may differ by
constexpr double kOffLattice = 0.05;  ///< of a step: floats of decimal steps are off it
constexpr double kMostSteps = 1e4;    ///< of a gap that tells anything
constexpr double kFarGaps = 0.01;     ///< of the gaps, that may be wider
constexpr double kLeastPlaces = 4;
constexpr double kAsWide = 1.0 / 3;  ///< of the points' distance: steps of a grid
constexpr double kCopies = 0.02;  ///< of the points: rounding puts some in one place, a grid none

/// Distances between neighbouring coordinates, rising.
std::vector<double> gaps_of(std::vector<double>& x) {
    std::sort(x.begin(), x.end());
    const double same = kSame * (x.back() - x.front());
    std::vector<double> gaps;
    for (std::size_t i = 1; i < x.size(); ++i)
        if (x[i] - x[i - 1] > same) gaps.push_back(x[i] - x[i - 1]);
    std::sort(gaps.begin(), gaps.end());
    return gaps;
}

/// The least gap, made better by the wider ones, if all are multiples of it.
double step_of(std::vector<double>& x) {
    const std::vector<double> gaps = gaps_of(x);
    if (static_cast<double>(gaps.size()) + 1 < kLeastPlaces) return 0;
    double length = 0, n_steps = 0, step = gaps.front();
    std::size_t n_far = 0;
    for (const double gap : gaps) {
        const double steps = std::round(gap / step);
        if (steps > kMostSteps) {
            ++n_far;
            continue;
        }
        if (std::abs(gap - steps * step) > kOffLattice * step) return 0;
        length += gap, n_steps += steps;
        step = length / n_steps;
    }
    return static_cast<double>(n_far) <= kFarGaps * static_cast<double>(gaps.size()) ? step : 0;
}

/// How far points are from the next along the curve, in the median, and the share of those that lie
/// where the next does.
struct Neighbours {
    double distance = 0, copies = 0;
};

Neighbours neighbours_of(const PointTree& points, std::size_t stride) {
    std::vector<double> distances;
    double copies = 0;
    for (std::size_t i = 0; i + 1 < points.size(); i += stride) {
        const double d = length(points.position(i + 1) - points.position(i));
        if (d > 0)
            distances.push_back(d);
        else
            copies += 1;
    }
    if (distances.empty()) return {};
    copies /= copies + static_cast<double>(distances.size());
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return {*middle, copies};
}

}  // namespace

Vec3d coordinate_steps(const PointTree& points) {
    if (points.size() < kLeastPoints) return {};
    const std::size_t stride = (points.size() - 1) / kSample + 1;
    std::array<std::vector<double>, 3> x;
    for (std::size_t i = 0; i < points.size(); i += stride) {
        const Vec3d p = points.position(i);
        x[0].push_back(p.x), x[1].push_back(p.y), x[2].push_back(p.z);
    }
    std::array<double, 3> step{};
    for (std::size_t a = 0; a < 3; ++a) step[a] = step_of(x[a]);
    const Neighbours next = neighbours_of(points, stride);
    const auto is_wide = [&](double s) { return s > kAsWide * next.distance; };
    if (std::count_if(step.begin(), step.end(), is_wide) >= 2 && next.copies < kCopies)
        for (double& s : step)
            if (is_wide(s)) s = 0;
    return {step[0], step[1], step[2]};
}

double rounding_noise(const Vec3d& steps, const Vec3d& normal) {
    const Vec3d along{steps.x * normal.x, steps.y * normal.y, steps.z * normal.z};
    return sq_length(along) / 12;
}

}  // namespace slim
