#include "slim/fit/normal_variance.h"

#include "slim/base/frame.h"
#include "slim/normals/covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim {
namespace {

constexpr double kRounding = 1e-14;
// as exact normals are; slices are averaged, and none may outvote the others
constexpr double kMostIndependent = 1;
constexpr std::size_t kSamples = 600, kFewSamples = 150, kVisits = 200000, kMostNeighbors = 1280,
                      kLargestShare = 50;

/// Sums of squares and products about the mean, from sums.
double about_mean(double products, double a, double b, double n) { return products - a * b / n; }

/// At one number of neighbours.
double independence_at(const NearestSearch& search, std::span<const std::uint32_t> samples,
                       std::span<const Vec3f> normals, std::size_t k) {
    const std::size_t n_wanted =
        std::min(samples.size(), std::clamp(kVisits / k, kFewSamples, kSamples));
    std::vector<std::uint32_t> wanted(samples.begin(),
                                      samples.begin() + static_cast<std::ptrdiff_t>(n_wanted));
    std::sort(wanted.begin(), wanted.end());
    std::vector<double> ratio(wanted.size(), INFINITY);
    search.for_each(wanted, k, [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
        if (neighbors.size() < 6) return;
        const Spread s = spread_of(search.positions(), neighbors);
        const double n = static_cast<double>(neighbors.size());
        const double variance = s.smallest / (n - 3) * (1 / s.middle + 1 / s.largest);
        const Vec3d own = to_double(normals[wanted[w]]);
        const Vec3d off = own - s.normal * std::copysign(1.0, dot(own, s.normal));
        if (variance > 0) ratio[w] = sq_length(off) / variance;
    });
    const auto middle = ratio.begin() + static_cast<std::ptrdiff_t>(ratio.size() / 2);
    std::nth_element(ratio.begin(), middle, ratio.end());
    // half a chi^2 of two degrees of freedom has the median ln 2
    return *middle / std::numbers::ln2;
}

}  // namespace

double normal_independence(const NearestSearch& search, std::span<const std::uint32_t> samples,
                           std::span<const Vec3f> normals, std::size_t first_k) {
    if (samples.empty() || normals.empty()) return 0;
    const std::size_t most = std::min(kMostNeighbors, search.size() / kLargestShare);
    double least = kMostIndependent;
    // Half-way between two k that differ by 2 an estimate still differs by half the variance.
    for (std::size_t k = first_k; k == first_k || (k <= most && k <= 16 * first_k);
         k += (2 * k + 4) / 5)
        least = std::min(least, independence_at(search, samples, normals, k));
    return least;
}

double normal_variance_of(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                          std::span<const std::uint32_t> points, const Vec3d& plane_normal) {
    if (points.size() < 4) return kRounding;
    const double n = static_cast<double>(points.size());
    const Frame<double> frame = frame_from_normal(plane_normal);
    double u = 0, v = 0, uu = 0, uv = 0, vv = 0;
    std::array<double, 2> m{}, mu{}, mv{}, mm{};
    const Vec3d first = positions[points[0]];
    for (const std::uint32_t i : points) {
        const Vec3d x = frame.local_from_world(positions[i] - first);
        const Vec3d k = frame.local_from_world(to_double(normals[i]));
        u += x.x, v += x.y;
        uu += x.x * x.x, uv += x.x * x.y, vv += x.y * x.y;
        for (std::size_t c = 0; c < 2; ++c) {
            const double along = c == 0 ? k.x : k.y;
            m[c] += along, mu[c] += along * x.x, mv[c] += along * x.y, mm[c] += along * along;
        }
    }
    uu = about_mean(uu, u, u, n), uv = about_mean(uv, u, v, n), vv = about_mean(vv, v, v, n);
    const double det = uu * vv - uv * uv;
    double rest = 0;
    for (std::size_t c = 0; c < 2; ++c) {
        rest += about_mean(mm[c], m[c], m[c], n);
        if (!(det > 0)) continue;
        const double a = about_mean(mu[c], m[c], u, n), b = about_mean(mv[c], m[c], v, n);
        rest -= (a * a * vv - 2 * a * b * uv + b * b * uu) / det;
    }
    return std::max(rest / (2 * (n - 3)), kRounding);
}

}  // namespace slim
