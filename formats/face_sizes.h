#pragma once

#include "formats/face_edges.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// An edge beside which a surface is so narrow or so bent; `size` (model units) at the edge, a
/// share of the distance more farther off (graded, as Ruppert 1995 and Persson 2006).
struct SizedEdge {
    static constexpr double kGrowth = 0.3;

    Vec3d from, to;
    double size;

    double distance(const Vec3d& p) const;
    double size_at(const Vec3d& p) const { return size + kGrowth * distance(p); }
};

/// How large the parts are that a mesh's faces bound: plates, ribs, rods, small solids beside large
/// ones. Faces joined by edges that turn less than 40 degrees are a region. Edges about a region
/// are of the size of the narrower region beside them: twice its area over its outline, which is a
/// strip's width and a disc's radius; those inside are as large as the radius of
/// their turn, or as the facets are wide if these turn by 12 degrees or more.
/// Edges of a piece that run side by side and bound no region together are no larger than the way
/// between them (slim/fit/notes/0018).
/// Connected pieces whose faces are mostly small are sampled by their vertices: nothing is said of
/// them.
class FaceSizes {
public:
    /// A face is large with an edge or a way across longer than `large` (model units) and than the
    /// share `large_share` of its piece's diagonal.
    /// cost  60 bytes a corner while it works, O(n log n); each pair of up to 2,000 sharp edges
    FaceSizes(const FaceList& faces, double large, double large_share);

    std::size_t n_regions() const { return begin_.size() - 1; }
    std::uint32_t region_of(std::size_t face) const { return region_[face]; }
    /// Empty if nothing is said of the region; chains of short edges are one (joined_edges.h).
    std::span<const SizedEdge> edges_of(std::size_t region) const {
        return std::span(edges_).subspan(begin_[region], begin_[region + 1] - begin_[region]);
    }

private:
    std::vector<std::uint32_t> region_;  ///< of each face
    std::vector<std::size_t> begin_;     ///< in edges_, of each region, and the end
    std::vector<SizedEdge> edges_;
};

}  // namespace slim
