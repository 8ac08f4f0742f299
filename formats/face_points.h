#pragma once

#include "formats/sized_parts.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <optional>
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
    /// Whether any face is large, so that sizes of parts are worth finding.
    bool wants_sizes() const;
    /// Then, if wanted, all faces again, in the order of measure() and sample(): adds the points of
    /// faces of which a size is known (FaceSizes), as dense as a share of it; these get no others.
    void sample_sized(const FaceList& faces, std::vector<Point>& out);
    /// Then again: adds the points of a face, about one per square of the spacing, to `out`. None
    /// for faces that are small, without area, not finite, or whose outline crosses itself.
    void sample(std::span<const Vec3d> corners, std::span<const std::size_t> vertices,
                std::vector<Point>& out);

    double spacing() const { return spacing_; }
    /// The size below which parts have fewer points than they ask for, as there would be too many;
    /// 0: none has.
    double least_size() const { return least_size_; }

private:
    bool are_at_most(double most, const FaceList& faces, const SizedSpacing& spacing) const;
    double densest_within(double most, const FaceList& faces, const SizedSpacing& spacing) const;
    void sample_triangle(const Triangle& corner, double spacing, const Vec3d& normal,
                         std::size_t vertex, std::vector<Point>& out);

    std::vector<float> edges_;  ///< lengths
    double area_ = 0, spacing_ = 0, median_ = 0, most_extent_ = 0, diagonal_ = 0;
    std::size_t n_vertices_ = 0;
    std::optional<FaceSizes> sizes_;
    double least_size_ = 0;
    std::size_t n_faces_ = 0;      ///< given to sample() so far
    std::size_t n_triangles_ = 0;  ///< sampled so far
};

}  // namespace slim
