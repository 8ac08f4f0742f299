#pragma once

#include "slim/base/vec.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/nearest.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// What a sample of points says of their normals as a whole. Sums, so that those of slices add up;
/// they are weighted by the area that a point stands for, which is as its neighbours are far.
struct NormalEvidence {
    std::size_t n = 0;       ///< points looked at that have a normal
    std::size_t n_flat = 0;  ///< of these, whose neighbours lie in a plane
    std::size_t n_off = 0;   ///< of those, whose normal is more than 45 degrees off the plane's
    double area = 0, sq_size = 0;  ///< sq_size: of area times squared length of the position
    double flux = 0;               ///< of area times position . normal
    Vec3d moment{}, area_vector{};  ///< of area times position, and times normal
    /// Of squared area times: squared position . normal; the same times normal; normal . normal^T
    /// (xx, xy, xz, yy, yz, zz). They say how much of the flux is chance.
    double sq_flux = 0;
    Vec3d flux_normals{};
    std::array<double, 6> normal_squares{};

    NormalEvidence& operator+=(const NormalEvidence& o);
    /// Makes the sample count as so many points, so that slices of unlike size add up.
    void stand_for(std::size_t n_points);
    /// As all normals turned round have it.
    void flip() { flux = -flux, area_vector = -area_vector; }

    /// Whether the normals cannot be those of the surface that the points make: constant ones on an
    /// object, others' ones. Of right ones of real scans up to 0.1 % are off, of upright ones on a
    /// city 0.8 % (notes/0004).
    bool is_off_surface() const;
    /// Whether the surface is closed but for small holes and the normals point into it: by a clear
    /// share of its size or, as rods and pipes enclose little, by far more than chance. Terrain,
    /// walls and single views enclose nothing, of them nothing is known; a room scanned from inside
    /// rightly has such normals.
    bool is_inward() const;

private:
    double flux_chance(const Vec3d& center) const;
};

/// Evidence of some points, from 16 neighbours each, or from more where these would be strips of
/// scan lines (neighbors_beyond_strips). Normals are unit vectors or zero.
/// points: in Morton order; search: over their positions; samples: any order, without repeats
/// Cost: 1.5 us a sample. Deterministic.
NormalEvidence evidence_of(const PointBlock& points, const NearestSearch& search,
                           std::span<const std::uint32_t> samples,
                           std::size_t neighbors = 16);

}  // namespace slim
