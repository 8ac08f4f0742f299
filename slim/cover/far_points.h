#pragma once

#include "slim/model/surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// A point that the blend of the leaves passes by.
struct FarPoint {
    std::uint32_t place;  ///< in the tree
    double off;           ///< distance along its normal, length; infinite where no leaf is met
};

/// The places of a tree that far_points() should look at, rising: all but those where each leaf
/// that may take part in the blend is well within `farthest` to first order, as a mean of them then
/// is, and one surely does. Cost: for each leaf a gather of its ball and a few ns a point in it.
std::vector<std::uint32_t> maybe_far(const PointTree& points,
                                     const std::vector<const Surfel*>& leaves, double farthest);

/// The points, of some places of a tree, that are farther than `farthest` from the blend of the
/// leaves along their own normals (eq. (6), Ohtake 2005; NUMERICS 5.5), in the order of the places;
/// sound: along sound_normal(). Points without a normal are left out. places: rising, so that
/// neighbours are looked at together. The same for any number of threads. Cost: about 1 us a place,
/// and for each of up to 64 pieces of them a test of its box against every leaf.
std::vector<FarPoint> far_points(const PointTree& points, std::span<const std::uint32_t> places,
                                 const std::vector<const Surfel*>& leaves, double farthest,
                                 bool sound = false);

}  // namespace slim
