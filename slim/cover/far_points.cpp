#include "slim/cover/far_points.h"

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/blend/blend.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

using Places = std::span<const std::uint32_t>;
using Leaves = std::vector<const Surfel*>;

constexpr std::size_t kTogether = 16;   // places that share a list of leaves
constexpr std::size_t kPieces = 64;     // of the places, for threads
constexpr std::size_t kLeastPiece = 1024;

/// Looks at places that lie together: at those of either half with the leaves that may hold them.
class FarSearch {
public:
    FarSearch(const PointTree& points, double farthest) : points_(points), farthest_(farthest) {}

    void look(Places places, const Leaves& leaves, std::vector<FarPoint>& out) const {
        Bbox box;
        for (const std::uint32_t place : places) box.extend(points_.position(place));
        const Leaves near = meeting(box, leaves);
        if (places.size() > kTogether) {
            const std::size_t half = places.size() / 2;
            look(places.first(half), near, out);
            look(places.subspan(half), near, out);
            return;
        }
        for (const std::uint32_t place : places) look_at(place, near, out);
    }

private:
    static Leaves meeting(const Bbox& box, const Leaves& leaves) {
        Leaves near;
        for (const Surfel* s : leaves)
            if (box.sq_distance(s->center) < s->support_radius * s->support_radius) near.push_back(s);
        return near;
    }
    void look_at(std::uint32_t place, const Leaves& leaves, std::vector<FarPoint>& out) const {
        const Vec3d n = to_double(points_.normal(place));
        if (!(sq_length(n) > 0)) return;
        const Vec3d p = points_.position(place);
        const Leaves supporters = meeting({p, p}, leaves);
        const auto at = project_along(p, normalized(n), supporters);
        const double off = at ? std::abs(at->t) : INFINITY;
        if (off > farthest_) out.push_back({place, off});
    }

    const PointTree& points_;
    double farthest_;
};

}  // namespace

std::vector<FarPoint> far_points(const PointTree& points, Places places, const Leaves& leaves, double farthest) {
    const FarSearch search(points, farthest);
    const std::size_t piece = std::max(kLeastPiece, (places.size() + kPieces - 1) / kPieces);
    std::vector<std::vector<FarPoint>> found((places.size() + piece - 1) / piece);
    parallel_blocks(places.size(), piece, [&](std::size_t begin, std::size_t end) {
        search.look(places.subspan(begin, end - begin), leaves, found[begin / piece]);
    });
    std::vector<FarPoint> out;
    for (const auto& f : found) out.insert(out.end(), f.begin(), f.end());
    return out;
}

}  // namespace slim
