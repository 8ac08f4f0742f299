#pragma once

#include "slim/model/point_block.h"
#include "slim/normals/estimate.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace slim {

/// How the sign of estimated normals was found.
struct OrientReport {
    std::size_t by_sensor = 0;
    /// spread over the neighbour graph from points with a known sign
    std::size_t by_neighbors = 0;
    std::size_t by_rule = 0;       ///< their component holds no point with a known sign
    std::size_t by_hints = 0;      ///< of these: as most of the normals that hint have it
    std::size_t components = 0;    ///< of the neighbour graph without a known sign
    /// its main part has no outside, as a terrain or a wall
    bool flat = false;
    /// it was taken for an airborne scan: each normal upwards by itself
    bool from_above = false;
};

/// Turns the normals of `wanted` towards their scan's sensor (frame of the block). Points of scans
/// without an entry in `sensors` are left.
std::size_t orient_to_sensors(PointBlock& points, std::span<const std::uint32_t> wanted,
                              std::span<const Vec3d> sensors);

/// The normal that a point has in a sample that was oriented at once.
struct SampledNormal {
    std::uint32_t point;
    Vec3f normal;
};

/// The whole cloud, where the points are those of one slice of it and its rim.
struct WholeScene {
    Vec3d center;
    bool has_sample = false;
    std::span<const SampledNormal> sampled = {};  ///< of points of the slice
    bool is_flat = false;                         ///< as OrientReport says of the sample
};

/// Gives the points with unknown sign (`known[i]` false) a consistent one: neighbours vote on
/// whether their signs agree (sign_groups), groups of points are joined by the sum of votes, the
/// surest first (sign_merge). Points whose sign is known vote as one and pass their signs on; a
/// component without them is turned so that its flux about its centroid is outwards, or what it
/// encloses if it is slender (Enclosure, notes/0007); where that says nothing (a terrain, a wall),
/// upwards (+z); where moreover four of five normals are less than 60 degrees steep (airborne
/// scans), each of those by itself.
/// whole: of a slice; a component that reaches out of it (points with counted[i] false) is turned
/// as the sample has it, else by its flux about the whole's centre. counted: the report is of those
/// points; empty: of all. seen_from_above: these rules, which found the known signs in a slice
/// before, saw an airborne scan there: it is one here too, where slopes might look like an outside.
/// hints: normals that are wrong here and there: a component's side is theirs where 85 % agree or,
/// unless its shape is closed, by more than chance (notes/0006). Own code, not CGAL's
/// mst_orient_normals, whose spanning tree a single pair at a crease can mislead (notes/0002);
/// deterministic, no search anew. Cost: 0.7 to 1.2 us a point on two threads, 3 in thick noise; 40
/// to 150 bytes a point.
OrientReport orient_by_neighbors(PointBlock& points, NeighborGraph graph,
                                 std::vector<bool>& known,
                                 const std::optional<WholeScene>& whole = std::nullopt,
                                 std::span<const Vec3f> hints = {},
                                 const std::vector<bool>& counted = {},
                                 bool seen_from_above = false);

}  // namespace slim
