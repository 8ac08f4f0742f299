#include "formats/face_triangles.h"

#include <algorithm>
#include <numeric>

namespace slim {
namespace {

/// Whether the fan about the first corner covers the face once.
bool is_fan(std::span<const Vec3d> corners, const Vec3d& area) {
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        if (dot(cross(corners[k] - corners[0], corners[k + 1] - corners[0]), area) < 0)
            return false;
    return true;
}

/// Whether the triangle (a, b, c), which turns as the face does, holds no other corner's place.
bool is_ear(std::span<const Vec3d> corners, std::span<const std::size_t> ring, const Corners& ear,
            const Vec3d& area) {
    const Vec3d &a = corners[ear[0]], &b = corners[ear[1]], &c = corners[ear[2]];
    if (!(dot(cross(b - a, c - b), area) > 0)) return false;
    const auto is_left = [&](const Vec3d& from, const Vec3d& to, const Vec3d& p) {
        return dot(cross(to - from, p - from), area) >= 0;
    };
    return std::none_of(ring.begin(), ring.end(), [&](std::size_t k) {
        const Vec3d& p = corners[k];
        return p != a && p != b && p != c && is_left(a, b, p) && is_left(b, c, p) &&
               is_left(c, a, p);
    });
}

}  // namespace

double fan_area(std::span<const Vec3d> corners) {
    double sum = 0;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        sum += length(cross(corners[k] - corners[0], corners[k + 1] - corners[0])) / 2;
    return sum;
}

double extent_of(std::span<const Vec3d> corners) {
    double most = 0;
    for (std::size_t k = 0; k < corners.size(); ++k)
        most = std::max({most, length(corners[(k + 1) % corners.size()] - corners[k]),
                         length(corners[k] - corners[0])});
    return most;
}

std::vector<Corners> triangles_of(std::span<const Vec3d> corners, const Vec3d& area) {
    constexpr std::size_t kMostConcave = 500;
    std::vector<Corners> out;
    if (is_fan(corners, area)) {
        for (std::size_t k = 1; k + 1 < corners.size(); ++k) out.push_back({0, k, k + 1});
        return out;
    }
    if (corners.size() > kMostConcave) return out;
    std::vector<std::size_t> ring(corners.size());
    std::iota(ring.begin(), ring.end(), std::size_t{0});
    while (ring.size() > 2) {
        const std::size_t n = ring.size();
        std::size_t k = 0;
        const auto ear = [&] { return Corners{ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]}; };
        while (k < n && !is_ear(corners, ring, ear(), area)) ++k;
        if (k == n) return {};
        out.push_back(ear());
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(k));
    }
    return out;
}

}  // namespace slim
