#include "slim/fit/normal_variance.h"

#include "slim/base/frame.h"

#include <algorithm>
#include <array>

namespace slim {
namespace {

constexpr double kRounding = 1e-14;

/// Sums of squares and products about the mean, from sums.
double about_mean(double products, double a, double b, double n) { return products - a * b / n; }

}  // namespace

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
