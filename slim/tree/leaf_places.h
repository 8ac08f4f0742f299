#pragma once

#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <array>
#include <cstddef>
#include <vector>

namespace slim {

/// The most that a polynomial can be where |(u, v)| <= radius.
double most_height(const Polynomial<double>& p, double radius);

inline constexpr std::size_t kPlacesOfSheet = 19, kMostPlaces = kPlacesOfSheet * kMostSheets;

struct LeafPlace {
    Vec3d position;
    std::size_t number;  ///< below kMostPlaces
};

/// Appends places on what is drawn of a leaf: of each sheet the middle and two rings of 6 and 12 at
/// a half of the core's radius and at all of it, drawn towards the middle until they are in the
/// core, and of these the ones on the side of its rims that is drawn; of sharp leaves those on the
/// joined surface. Local frame. `first` says how many of the sheet's places to look at.
void append_places(const Surfel& leaf, std::vector<LeafPlace>& out,
                   std::size_t first = kPlacesOfSheet);

/// The same of more places, in 96 directions at quarters of the core's radius and where what is drawn
/// ends between them: tips between a core's circle and a rim, and corners, lie between the 19.
void append_close_places(const Surfel& leaf, std::vector<LeafPlace>& out);

/// What holds all places of a leaf: discs about its centre with a height to both sides.
struct LeafExtent {
    struct Disc {
        Vec3d normal;
        double radius, height;
    };
    std::array<Disc, kMostSheets> disc;
    std::size_t n_discs;

    explicit LeafExtent(const Surfel& leaf);
    /// How far any place is from the centre along each axis, at most.
    Vec3d along_axes() const;
};

/// Radius of a ball about the centre of leaf `node` that holds all its places. Reads the record
/// alone unless the leaf is sharp.
double radius_of_places(const SurfelTree& tree, std::size_t node);

}  // namespace slim
