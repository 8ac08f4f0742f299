#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Polygons as flat arrays; corners number positions.
struct FaceList {
    std::span<const Vec3d> position;
    std::vector<std::uint32_t> corner;
    std::vector<std::size_t> end;  ///< in `corner`, of each face

    std::size_t size() const { return end.size(); }
    std::span<const std::uint32_t> operator[](std::size_t face) const {
        const std::size_t begin = face == 0 ? 0 : end[face - 1];
        return std::span(corner).subspan(begin, end[face] - begin);
    }
};

/// Which faces meet at which edges, and how they turn there. Vertices of one place are one: many
/// programs write every face's own. Faces without area, or with corners that are not finite, take
/// no part.
/// cost  16 bytes a corner and 36 a face; O(n log n)
class FaceEdges {
public:
    struct Side {
        std::uint32_t a, b;     ///< vertices, a < b, one for all of a place
        std::uint32_t face;
        bool forward;           ///< the face goes from a to b
    };

    explicit FaceEdges(const FaceList& faces);

    double area(std::size_t face) const { return area_[face]; }  ///< zero: takes no part
    double length_of(const Side& side) const;
    /// Between the normals of two faces, radians, however they are wound.
    double turn(const Side& first, const Side& second) const;
    /// Of a face across from one of its edges: of a triangle and a quadrangle exact.
    double width(const Side& side) const;

    /// take(sides): those of all faces at an edge, each edge once.
    template <class Take>
    void for_each_edge(const Take& take) const {
        for (std::size_t i = 0, j = 0; i < sides_.size(); i = j) {
            while (j < sides_.size() && sides_[j].a == sides_[i].a && sides_[j].b == sides_[i].b)
                ++j;
            take(std::span(sides_).subspan(i, j - i));
        }
    }

private:
    void find_normals();

    const FaceList& faces_;
    std::vector<Vec3d> normal_;
    std::vector<double> area_;
    std::vector<Side> sides_;  ///< sorted by vertices, then by face
};

}  // namespace slim
