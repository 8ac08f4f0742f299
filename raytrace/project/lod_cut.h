#pragma once

#include "raytrace/camera.h"
#include "raytrace/renderer.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// The part of space that a window of the picture sees, for tests of balls in camera coordinates.
class ViewVolume {
public:
    ViewVolume(const PixelView& view, const PixelWindow& window);

    /// False only if no point of the ball is seen (conservative).
    bool may_see(const Vec3d& center, double radius) const {
        return depth_within(center) >= -radius;
    }
    /// How far a point lies within the plane that it is least within; negative outside.
    double depth_within(const Vec3d& center) const;

private:
    struct Plane {
        Vec3d normal;  ///< unit, inwards
        double offset;
    };
    Plane planes_[5];
};

/// Projected diameter of a small ball across its longer axis, which off the picture's middle points
/// away from it, pixels; infinite if the ball reaches the eye's plane.
double projected_diameter(const PixelView& view, const Vec3d& center_in_camera, double radius);

/// Which of the tree's surfels a cut takes, and what it met.
struct CutRules {
    double lod_px = 0;   ///< descend while a ball's projected diameter exceeds it; 0: leaves only
    bool loose = false;  ///< take loose surfels as well
};
struct CutCounts {
    std::uint64_t nodes_visited = 0;
    std::uint64_t loose_hidden = 0;  ///< loose surfels that the cut would hold otherwise
    std::vector<std::uint32_t>* visited = nullptr;  ///< if set: gets the nodes visited
};

/// The surfels to draw (Ohtake 2005, sec. 3, "view dependent refinement"): from the root down while
/// the ball of a node meets the view and its projected diameter exceeds lod_px; leaves wherever
/// they are met, and with lod_px = 0 leaves only. An internal node drawn stands in for all below
/// it; where that is finer than the picture, a larger one may (project/notes/0005).
/// Order: generation by generation, families in the order of their parents; large generations in
/// parallel. Adds to the counts. Throws FormatError on a child that does not come after its parent
/// (a cycle) or lies outside the tree, and where nodes are met twice.
std::vector<std::uint32_t> lod_cut(const SurfelTree& tree, const PixelView& view,
                                   const PixelWindow& window, const CutRules& rules,
                                   CutCounts& counts);

}  // namespace slim
