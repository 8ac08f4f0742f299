#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <span>
#include <vector>

namespace slim {

/// Points on faces that are large against the others of a mesh (or its extent), where the vertices
/// alone would leave the surface without support: the caps and sides of CAD models, the base of a
/// reduced scan (formats/notes/0003).
class FacePoints {
public:
    struct Point {
        Vec3d position, normal;  ///< normal: unit, as the face is wound
        std::size_t vertex;      ///< one of the face's
    };

    /// First all faces once, for what is large. Corners: of one face, as positions.
    void measure(std::span<const Vec3d> corners);
    /// diagonal: of the vertices
    void choose_spacing(double diagonal, std::size_t n_vertices);
    /// Then again: adds the points of a face, about one per square of the spacing, to `out`. None
    /// for faces that are small, without area, not finite, or whose outline crosses itself.
    void sample(std::span<const Vec3d> corners, std::span<const std::size_t> vertices,
                std::vector<Point>& out);

    double spacing() const { return spacing_; }

private:
    void sample_triangle(const Vec3d (&corner)[3], const Vec3d& normal, std::size_t vertex,
                         std::vector<Point>& out);

    std::vector<float> edges_;  ///< lengths
    double area_ = 0, spacing_ = 0;
    std::size_t n_triangles_ = 0;  ///< sampled so far
};

}  // namespace slim
