#pragma once

#include "formats/face_sizes.h"
#include "formats/face_triangles.h"

#include <cstdint>
#include <functional>
#include <span>

namespace slim {

/// Spacing of points by the size of what they lie on.
struct SizedSpacing {
    double share;        ///< of the size
    double least, most;  ///< model units

    double at(const Vec3d& p, std::span<const SizedEdge> edges) const;
};

/// A piece of a face of which the size is known, and the spacing that its points are to have.
struct SizedPart {
    Triangle corner;
    std::uint32_t face;
    double spacing;
};

/// Gives faces of known sizes in triangles within which the spacing differs little (by 2, or less
/// than they are wide), until `take` returns false.
/// cost  of n triangles with m edges about their region some n log m; n m where triangles are as
///       large as the region
void for_each_sized_part(const FaceList& faces, const FaceSizes& sizes,
                         const SizedSpacing& spacing,
                         const std::function<bool(const SizedPart&)>& take);

}  // namespace slim
