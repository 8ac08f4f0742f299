#include "formats/face_points.h"

#include "slim/base/area_vector.h"
#include "slim/base/hash.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr double kLarge = 5;          // edges over the median edge, of a face that gets points
// at most that share of the diagonal, however long the median edge is
constexpr double kMostSpacing = 60;
// points of a surface that is large faces all over, for each vertex ...
constexpr double kMostPerVertex = 4;
constexpr double kFewVertices = 12500;  // ... but as for so many vertices at least
constexpr double kShare = 0.15;       // spacing over the size of what faces bound
constexpr double kFewSized = 50000;   // as kFewVertices, where parts are narrow
constexpr double kFinest = 20000;     // no denser than that share of the diagonal
constexpr double kCoarser = 1.2;      // step towards fewer points
constexpr std::uint64_t kPlaces = 0x66616365;  // purpose of the hash

}  // namespace

void FacePoints::measure(std::span<const Vec3d> corners) {
    if (corners.size() < 3) return;
    const double area = fan_area(corners);
    if (!std::isfinite(area)) return;
    area_ += area;
    most_extent_ = std::max(most_extent_, extent_of(corners));
    for (std::size_t k = 0; k < corners.size(); ++k)
        edges_.push_back(
            static_cast<float>(length(corners[(k + 1) % corners.size()] - corners[k])));
}

void FacePoints::choose_spacing(double diagonal, std::size_t n_vertices) {
    if (edges_.empty()) return;
    const auto middle = edges_.begin() + static_cast<std::ptrdiff_t>(edges_.size() / 2);
    std::nth_element(edges_.begin(), middle, edges_.end());
    median_ = *middle, diagonal_ = diagonal, n_vertices_ = n_vertices;
    const double most = kMostPerVertex * std::max(static_cast<double>(n_vertices), kFewVertices);
    spacing_ = std::max(std::min(median_, diagonal / kMostSpacing), std::sqrt(area_ / most));
    edges_ = {};
}

bool FacePoints::wants_sizes() const {
    return spacing_ > 0 && std::isfinite(spacing_) && most_extent_ > kLarge * spacing_ &&
           n_vertices_ < std::numeric_limits<std::uint32_t>::max();
}

void FacePoints::sample_sized(const FaceList& faces, std::vector<Point>& out) {
    const bool dense = median_ <= diagonal_ / kMostSpacing;  // a mesh that its vertices sample
    const double large_share =
        dense ? std::numeric_limits<double>::infinity() : kLarge / kMostSpacing;
    sizes_.emplace(faces, kLarge * median_, large_share);
    SizedSpacing spacing{kShare, diagonal_ / kFinest, spacing_};
    const double most = kMostPerVertex * std::max(static_cast<double>(n_vertices_), kFewSized);
    if (!are_at_most(most, faces, spacing)) {
        spacing.least = densest_within(most, faces, spacing);
        least_size_ = spacing.least / kShare;
    }
    for_each_sized_part(faces, *sizes_, spacing, [&](const SizedPart& part) {
        const auto face = faces[part.face];
        sample_triangle(part.corner, part.spacing, normalized(area_vector(faces.position, face)),
                        face[0], out);
        return true;
    });
}

/// Whether so many points are enough; does not look further than that takes.
bool FacePoints::are_at_most(double most, const FaceList& faces,
                             const SizedSpacing& spacing) const {
    double n_points = 0, n_parts = 0;
    for_each_sized_part(faces, *sizes_, spacing, [&](const SizedPart& part) {
        n_points += fan_area(part.corner) / (part.spacing * part.spacing), ++n_parts;
        return n_points <= most && n_parts <= most;
    });
    return n_points <= most && n_parts <= most;
}

/// The least spacing, in steps of kCoarser from spacing.least on, that asks for at most so many
/// points; spacing.most where none does.
double FacePoints::densest_within(double most, const FaceList& faces,
                                  const SizedSpacing& spacing) const {
    const auto at_step = [&](int step) {
        return SizedSpacing{spacing.share, spacing.least * std::pow(kCoarser, step), spacing.most};
    };
    int too_dense = 0, enough = 1;
    while (at_step(enough).least < spacing.most) ++enough;
    while (enough - too_dense > 1) {
        const int middle = (too_dense + enough) / 2;
        (are_at_most(most, faces, at_step(middle)) ? enough : too_dense) = middle;
    }
    return std::min(at_step(enough).least, spacing.most);
}

void FacePoints::sample(std::span<const Vec3d> corners, std::span<const std::size_t> vertices,
                        std::vector<Point>& out) {
    const std::size_t face = n_faces_++;
    if (sizes_ && !sizes_->edges_of(sizes_->region_of(face)).empty()) return;
    if (corners.size() < 3 || !(spacing_ > 0) || !std::isfinite(spacing_)) return;
    const Vec3d area = area_vector(corners);
    const double size = length(area);
    if (!(size > 0) || !std::isfinite(size) || !(extent_of(corners) > kLarge * spacing_))
        return;
    for (const Corners& t : triangles_of(corners, area))
        sample_triangle({corners[t[0]], corners[t[1]], corners[t[2]]}, spacing_, area / size,
                        vertices[0], out);
}

/// In rows along the longest edge, evenly, half a row from the edges (notes/0003). Of a sliver,
/// where it is widest most.
void FacePoints::sample_triangle(const Triangle& corner, double spacing, const Vec3d& normal,
                                 std::size_t vertex, std::vector<Point>& out) {
    std::size_t a = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (sq_length(corner[(k + 1) % 3] - corner[k]) > sq_length(corner[(a + 1) % 3] - corner[a]))
            a = k;
    const Vec3d from = corner[a], along = corner[(a + 1) % 3] - from,
                apex = corner[(a + 2) % 3] - from;
    const double width = length(along), height = length(cross(along, apex)) / width;
    const double foot = std::clamp(dot(apex, along) / (width * width), 0.0, 1.0);
    const Vec3d up = apex - foot * along;
    const double rows = std::round(height / spacing);
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
        const double n = whole(width * height / (2 * spacing * spacing), 0);
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
                     n = whole((1 - t) * width * height / rows / (spacing * spacing), r);
        for (double i = 0; i < n; ++i) add(t * foot + (1 - t) * (i + 0.5) / n, t);
    }
}

}  // namespace slim
