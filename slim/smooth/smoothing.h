#pragma once

#include "slim/smooth/local_noise.h"
#include "slim/smooth/mesh.h"
#include "slim/smooth/refit.h"
#include "slim/smooth/turned_faces.h"
#include "slim/tree/ball_index.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace slim {

/// How far points go.
struct SmoothSettings {
    int iterations = 1;
    double amount = 1;  ///< share of the way to the surface, 0 to 1
    double most = 0;    ///< no point ends farther from where it was; 0: no limit
};

/// A point after smoothing.
struct SmoothedPoint {
    Vec3d position;           ///< as it was if it did not move
    Vec3d normal;             ///< of the model by eq. (7), unit; its own if it did not move
    double displacement = 0;  ///< how far it went, positive along `normal`
    bool moved = false;       ///< to the place that the model had for it, or on the way there
    bool held = false;        ///< a vertex of a mesh's boundary
    bool by_model = false;    ///< the model's own surface served, the fits made anew were out of
                              ///< reach or another sheet's
    /// Went only a share of the way: the surface is farther off there than the point's noise. A
    /// vertex that did not move: else it would turn a face over.
    bool held_back = false;
    bool opposed = false, astray = false;  ///< as PointProjector says, in the first iteration
};

/// What points are put on: a model, and where there is one its surface fitted anew,
/// which goes first.
struct SmoothSurface {
    const BallIndex& model;
    const RefittedSurface* refitted = nullptr;
    std::span<const LeafTrust> trust = {};  ///< of the model's leaves; none: points go all the way
};

/// Projects points on the model along their normals (Ohtake 2005, sec. 4, eqs (6) and (7)), again
/// from where that ends with the normals found there; along the model's where theirs cannot be
/// trusted (kTrustedCosine). A point that is held back goes its share of the whole way, which the
/// first iteration says: what is left of its distance is the surface's error, however often it is
/// asked. Points that no surfel supports, whose lines meet nothing or that are not finite stay.
/// Frame of the job; `normals` empty: along the model's own. out.size() == positions.size(). In
/// parallel, same values for any thread count.
void smooth_points(const SmoothSurface& surface, const SmoothSettings& settings,
                   std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                   std::span<SmoothedPoint> out);

/// What became of a mesh.
struct SmoothedMesh {
    std::vector<SmoothedPoint> vertices;
    std::uint64_t faces_unsupported = 0;  ///< in the first iteration: they keep their own planes
    TurnedFaces turned;
};

/// Projects the faces' centroids and puts every vertex where it is nearest the planes there (Ohtake
/// 2005, sec. 4; NUMERICS 5.5). Vertices of the boundary stay, as do those of no face that the
/// model supports. Vertices that would turn a face over go a share of their way, or stay as well
/// (turned_faces.h).
/// Normals of the vertices: the mean of their planes' by area. `mesh` is left as smoothed.
/// each_step  called before each iteration
/// cost       about 200 bytes a vertex beside the mesh
SmoothedMesh smooth_mesh(const BallIndex& index, const SmoothSettings& settings, Mesh& mesh,
                         const std::function<void(int iteration)>& each_step);

}  // namespace slim
