#include "formats/face_points.h"

#include "slim/base/hash.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace slim {
namespace {

constexpr double kLarge = 5;          // edges over the median edge, of a face that gets points
// at most that share of the diagonal, however long the median edge is
constexpr double kMostSpacing = 60;
// points of a surface that is large faces all over, for each vertex ...
constexpr double kMostPerVertex = 4;
constexpr double kFewVertices = 12500;  // ... but as for so many vertices at least
constexpr std::uint64_t kPlaces = 0x66616365;  // purpose of the hash

Vec3d area_vector(std::span<const Vec3d> corners) {
    Vec3d sum;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        sum += cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
    return sum;
}

/// Of all triangles of the fan, which are what gets points: of a folded face more than its vector's
/// length.
double fan_area(std::span<const Vec3d> corners) {
    double sum = 0;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        sum += length(cross(corners[k] - corners[0], corners[k + 1] - corners[0])) / 2;
    return sum;
}

/// Of the face, edges and ways across from its first corner: what its vertices leave open.
double extent_of(std::span<const Vec3d> corners) {
    double most = 0;
    for (std::size_t k = 0; k < corners.size(); ++k)
        most = std::max({most, length(corners[(k + 1) % corners.size()] - corners[k]),
                         length(corners[k] - corners[0])});
    return most;
}

using Triangle = std::array<std::size_t, 3>;

/// Whether the fan about the first corner covers the face once.
bool is_fan(std::span<const Vec3d> corners, const Vec3d& area) {
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        if (dot(cross(corners[k] - corners[0], corners[k + 1] - corners[0]), area) < 0)
            return false;
    return true;
}

/// Whether the triangle (a, b, c), which turns as the face does, holds the place of no other corner.
bool is_ear(std::span<const Vec3d> corners, std::span<const std::size_t> ring, const Triangle& ear,
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

/// Triangles that cover a face once: a fan, or ears cut off one by one where it is concave
/// (Meisters 1975). None if its outline crosses itself, or of a concave one of too many corners.
/// cost  O(n^3) of a concave face
std::vector<Triangle> triangles_of(std::span<const Vec3d> corners, const Vec3d& area) {
    constexpr std::size_t kMostConcave = 500;
    std::vector<Triangle> out;
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
        const auto ear = [&] { return Triangle{ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]}; };
        while (k < n && !is_ear(corners, ring, ear(), area)) ++k;
        if (k == n) return {};
        out.push_back(ear());
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(k));
    }
    return out;
}

}  // namespace

void FacePoints::measure(std::span<const Vec3d> corners) {
    if (corners.size() < 3) return;
    const double area = fan_area(corners);
    if (!std::isfinite(area)) return;
    area_ += area;
    for (std::size_t k = 0; k < corners.size(); ++k)
        edges_.push_back(
            static_cast<float>(length(corners[(k + 1) % corners.size()] - corners[k])));
}

void FacePoints::choose_spacing(double diagonal, std::size_t n_vertices) {
    if (edges_.empty()) return;
    const auto middle = edges_.begin() + static_cast<std::ptrdiff_t>(edges_.size() / 2);
    std::nth_element(edges_.begin(), middle, edges_.end());
    const double most = kMostPerVertex * std::max(static_cast<double>(n_vertices), kFewVertices);
    spacing_ = std::max(std::min(static_cast<double>(*middle), diagonal / kMostSpacing),
                        std::sqrt(area_ / most));
    edges_ = {};
}

void FacePoints::sample(std::span<const Vec3d> corners, std::span<const std::size_t> vertices,
                        std::vector<Point>& out) {
    if (corners.size() < 3 || !(spacing_ > 0) || !std::isfinite(spacing_)) return;
    const Vec3d area = area_vector(corners);
    const double size = length(area);
    if (!(size > 0) || !std::isfinite(size) || !(extent_of(corners) > kLarge * spacing_))
        return;
    for (const Triangle& t : triangles_of(corners, area))
        sample_triangle({corners[t[0]], corners[t[1]], corners[t[2]]}, area / size, vertices[0],
                        out);
}

/// In rows along the longest edge, evenly, half a row from the edges (notes/0003). Of a sliver,
/// where it is widest most.
void FacePoints::sample_triangle(const Vec3d (&corner)[3], const Vec3d& normal, std::size_t vertex,
                                 std::vector<Point>& out) {
    std::size_t a = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (sq_length(corner[(k + 1) % 3] - corner[k]) > sq_length(corner[(a + 1) % 3] - corner[a]))
            a = k;
    const Vec3d from = corner[a], along = corner[(a + 1) % 3] - from,
                apex = corner[(a + 2) % 3] - from;
    const double width = length(along), height = length(cross(along, apex)) / width;
    const double foot = std::clamp(dot(apex, along) / (width * width), 0.0, 1.0);
    const Vec3d up = apex - foot * along;
    const double rows = std::round(height / spacing_);
    const std::uint64_t triangle = n_triangles_++;
    // What is less than a point is one with that chance.
    const auto whole = [&](double n, double row) {
        return std::floor(
            n + unit_interval(keyed_hash(triangle, static_cast<std::uint64_t>(row), kPlaces)));
    };
    const auto add = [&](double x, double t) {
        out.push_back({from + x * along + t * up, normal, vertex});
    };
    if (rows < 3) {
        const double n = whole(width * height / (2 * spacing_ * spacing_), 0);
        const double phase =
            unit_interval(keyed_hash(triangle, 3, kPlaces));  // else tips that meet leave a hole
        for (double i = 0; i < n; ++i) {
            const double share = (i + phase) / n;  // of the area on this side
            const double across = rows < 2 ? 0.5 : std::fmod(i, 2) < 1 ? 0.3 : 0.7;
            const double x =
                share < foot ? std::sqrt(share * foot) : 1 - std::sqrt((1 - share) * (1 - foot));
            add(x, across * (x < foot ? x / foot : (1 - x) / (1 - foot)));
        }
        return;
    }
    for (double r = 0; r < rows; ++r) {
        const double t = (r + 0.5) / rows,
                     n = whole((1 - t) * width * height / rows / (spacing_ * spacing_), r);
        for (double i = 0; i < n; ++i) add(t * foot + (1 - t) * (i + 0.5) / n, t);
    }
}

}  // namespace slim
