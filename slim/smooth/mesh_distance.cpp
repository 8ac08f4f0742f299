#include "slim/smooth/mesh_distance.h"

#include <algorithm>
#include <limits>

namespace slim {
namespace {

constexpr std::uint32_t kLeafSize = 4;

Vec3d centroid(const std::array<Vec3d, 3>& t) { return (t[0] + t[1] + t[2]) / 3.0; }

double sq_distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d ab = b - a;
    const double sq = sq_length(ab);
    const double t = sq > 0 ? std::clamp(dot(p - a, ab) / sq, 0.0, 1.0) : 0;
    return sq_length(p - (a + ab * t));
}

}  // namespace

double sq_distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d normal = cross(b - a, c - a);
    const double sq = sq_length(normal);
    // Inside the prism over the triangle: the distance to its plane. Otherwise to its nearest edge.
    const bool inside = sq > 0 && dot(cross(b - a, p - a), normal) >= 0 &&
                        dot(cross(c - b, p - b), normal) >= 0 &&
                        dot(cross(a - c, p - c), normal) >= 0;
    if (inside) {
        const double height = dot(p - a, normal);
        return height * height / sq;
    }
    return std::min({sq_distance_to_segment(p, a, b), sq_distance_to_segment(p, b, c),
                     sq_distance_to_segment(p, c, a)});
}

MeshDistance::MeshDistance(const Mesh& mesh) {
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto corners = mesh.face(f);
        for (std::size_t k = 2; k < corners.size(); ++k) {
            const Triangle t{mesh.position[corners[0]], mesh.position[corners[k - 1]],
                             mesh.position[corners[k]]};
            if (is_finite(t[0]) && is_finite(t[1]) && is_finite(t[2])) triangles_.push_back(t);
        }
    }
    nodes_.reserve(triangles_.size());
    if (!triangles_.empty()) build(0, static_cast<std::uint32_t>(triangles_.size()));
}

/// Halves by the median along the longest axis of the centroids: balanced, so the depth is log2 n.
std::uint32_t MeshDistance::build(std::uint32_t begin, std::uint32_t end) {
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{}, begin, end});
    Bbox box, middles;
    for (std::uint32_t i = begin; i < end; ++i) {
        for (const Vec3d& v : triangles_[i]) box.extend(v);
        middles.extend(centroid(triangles_[i]));
    }
    nodes_[at].box = box;
    if (end - begin <= kLeafSize) return at;
    const auto axis = static_cast<std::size_t>(middles.longest_axis());
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(triangles_.begin() + begin, triangles_.begin() + half,
                     triangles_.begin() + end, [axis](const Triangle& a, const Triangle& b) {
                         return centroid(a)[axis] < centroid(b)[axis];
                     });
    build(begin, half);
    const std::uint32_t right = build(half, end);
    nodes_[at].right = right;
    return at;
}

double MeshDistance::sq_distance(const Vec3d& p) const {
    double best = std::numeric_limits<double>::infinity();
    std::uint32_t stack[64];  // one waits a level, and there are at most 32
    std::size_t depth = 0;
    if (!nodes_.empty()) stack[depth++] = 0;
    while (depth > 0) {
        const std::uint32_t i = stack[--depth];
        const Node& node = nodes_[i];
        if (node.box.sq_distance(p) >= best) continue;
        if (node.right == 0) {
            for (std::uint32_t k = node.begin; k < node.end; ++k) {
                const Triangle& t = triangles_[k];
                best = std::min(best, sq_distance_to_triangle(p, t[0], t[1], t[2]));
            }
            continue;
        }
        // The nearer child first: it goes on top.
        const bool left_first = nodes_[i + 1].box.sq_distance(p) <
                                nodes_[node.right].box.sq_distance(p);
        stack[depth++] = left_first ? node.right : i + 1;
        stack[depth++] = left_first ? i + 1 : node.right;
    }
    return best;
}

}  // namespace slim
