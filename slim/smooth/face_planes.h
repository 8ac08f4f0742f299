#pragma once

#include "slim/smooth/mesh.h"
#include "slim/tree/ball_index.h"

#include <span>
#include <vector>

namespace slim {

/// Where a face shall lie.
struct FacePlane {
    Vec3d point;     ///< q_f: the centroid put on the model by eq. (6), or the centroid itself
    Vec3d normal;    ///< n_f: unit, by eq. (7), or the face's own
    double area = 0; ///< of the face as it is; 0: no plane
    bool supported = false;
};

/// Puts the centroid of every face on the model along the face's normal (Ohtake 2005, sec. 4).
/// Faces without area or with a corner that is not finite have no plane. In parallel, same values
/// for any thread count.
std::vector<FacePlane> project_faces(const Mesh& mesh, const BallIndex& index);

/// Moves x to where it is nearest the planes of some faces: minimises sum A_f (n_f.(y - q_f))^2 +
/// 0.03 A |y - x|^2, the quadric error metric of Garland and Heckbert (Ohtake 2005, sec. 4), along
/// the directions whose eigenvalue is at least 0.2 of the largest; along the others x stays.
/// Departs from NUMERICS 5.5, which pulls towards the mean of the q_f and truncates at 1e-2:
/// vertices then slide to the middle of their faces and shoot along directions that only noise
/// tells apart (notes/0001).
/// faces   numbers into planes; those without area do not count
/// returns false if none counts; x is not touched then
bool nearest_to_planes(std::span<const FacePlane> planes, std::span<const std::uint32_t> faces,
                       Vec3d& x);

}  // namespace slim
