#include "formats/sized_parts.h"

#include "slim/base/area_vector.h"
#include "slim/base/bbox.h"

#include <algorithm>
#include <vector>

namespace slim {
namespace {

constexpr double kMostRatio = 2;       // of spacings within a part
constexpr std::size_t kFewEdges = 16;  // of which each triangle looks for its own

using Edges = std::span<const SizedEdge>;

/// Those that may be the nearest somewhere in a ball.
std::vector<SizedEdge> edges_near(Edges edges, const Vec3d& center, double reach, double most) {
    for (const SizedEdge& e : edges) most = std::min(most, e.size_at(center));
    std::vector<SizedEdge> out;
    for (const SizedEdge& e : edges)
        if (e.size_at(center) <= most + 2 * SizedEdge::kGrowth * reach) out.push_back(e);
    return out;
}

class Divider {
public:
    Divider(const SizedSpacing& spacing, const std::function<bool(const SizedPart&)>& take)
        : spacing_(spacing), take_(take) {}

    bool ended() const { return ended_; }
    /// Triangles that lie together are given the edges near them, until these are few.
    void divide_together(std::span<SizedPart> parts, Edges edges) {
        if (ended_) return;
        if (parts.size() == 1 || edges.size() <= kFewEdges) {
            for (const SizedPart& part : parts) divide(part, edges);
            return;
        }
        Bbox box;
        for (const SizedPart& part : parts)
            for (const Vec3d& p : part.corner) box.extend(p);
        const auto near = edges_near(edges, box.center(), box.diagonal() / 2, most_size());
        const Vec3d extent = box.extent();
        std::size_t axis = 0;
        for (const std::size_t k : {1, 2})
            if (extent[k] > extent[axis]) axis = k;
        const auto middle = parts.begin() + static_cast<std::ptrdiff_t>(parts.size() / 2);
        const auto place = [axis](const SizedPart& part) {
            return part.corner[0][axis] + part.corner[1][axis] + part.corner[2][axis];
        };
        std::nth_element(parts.begin(), middle, parts.end(),
                         [&](const auto& a, const auto& b) { return place(a) < place(b); });
        divide_together({parts.begin(), middle}, near);
        divide_together({middle, parts.end()}, near);
    }

private:
    double most_size() const { return spacing_.most / spacing_.share; }

    /// In halves across the longest edge.
    void divide(SizedPart part, Edges edges) {
        if (ended_) return;
        const Triangle& corner = part.corner;
        const Vec3d center = (corner[0] + corner[1] + corner[2]) / 3;
        double reach = 0;
        for (const Vec3d& p : corner) reach = std::max(reach, length(p - center));
        const auto near = edges_near(edges, center, reach, most_size());
        double least = part.spacing = spacing_.at(center, near);
        double most = least;
        std::size_t a = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d &p = corner[k], &q = corner[(k + 1) % 3];
            if (sq_length(q - p) > sq_length(corner[(a + 1) % 3] - corner[a])) a = k;
            for (const double s : {spacing_.at(p, near), spacing_.at((p + q) / 2, near)})
                least = std::min(least, s), most = std::max(most, s);
        }
        if (most <= kMostRatio * least || reach < least) {
            ended_ = !take_(part);
            return;
        }
        const Vec3d p = corner[a], q = corner[(a + 1) % 3], apex = corner[(a + 2) % 3],
                    middle = (p + q) / 2;
        divide({{p, middle, apex}, part.face, 0}, near);
        divide({{middle, q, apex}, part.face, 0}, near);
    }

    SizedSpacing spacing_;
    const std::function<bool(const SizedPart&)>& take_;
    bool ended_ = false;
};

}  // namespace

double SizedSpacing::at(const Vec3d& p, std::span<const SizedEdge> edges) const {
    double size = most / share;
    for (const SizedEdge& e : edges) size = std::min(size, e.size_at(p));
    return std::clamp(share * size, std::min(least, most), most);
}

void for_each_sized_part(const FaceList& faces, const FaceSizes& sizes,
                         const SizedSpacing& spacing,
                         const std::function<bool(const SizedPart&)>& take) {
    std::vector<std::vector<SizedPart>> parts(sizes.n_regions());
    std::vector<Vec3d> corners;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        if (sizes.edges_of(sizes.region_of(f)).empty()) continue;
        corners.clear();
        for (const std::uint32_t v : faces[f]) corners.push_back(faces.position[v]);
        for (const Corners& t : triangles_of(corners, area_vector(corners)))
            parts[sizes.region_of(f)].push_back(
                {{corners[t[0]], corners[t[1]], corners[t[2]]}, f, 0});
    }
    Divider divider(spacing, take);
    for (std::size_t r = 0; r < parts.size() && !divider.ended(); ++r)
        if (!parts[r].empty()) divider.divide_together(parts[r], sizes.edges_of(r));
}

}  // namespace slim
