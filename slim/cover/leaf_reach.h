#pragma once

#include "slim/cover/covering_surfel.h"
#include "slim/model/rim.h"

#include <array>
#include <cstddef>
#include <optional>

namespace slim {

/// A number for each direction of a rim.
using PerDirection = std::array<float, kRimDirections>;

/// Entry of a direction, which may be counted round the circle by one turn.
inline std::size_t direction(int k) {
    return static_cast<std::size_t>((k + kRimDirections) % kRimDirections);
}

/// Directions, 56 degrees: what ends closer to another end of a leaf is the same one.
inline constexpr int kEndsApart = 5;

/// How far a leaf's covered points reach in each direction, over rho; at least 0, where the centre
/// is. Nothing once they reach farther than `longest`, by default any rim, everywhere, as they soon
/// do on most surfaces. Cost: 32 products a point.
std::optional<PerDirection> reaches_of(const CoveringSurfel& leaf,
                                       double longest = kRimReaches * kRimStep);

/// What the points of a leaf say of its end in a direction, over rho.
struct LeafEnd {
    double spacing;  ///< of the points in the part of the disc that they fill
    double margin;   ///< how far beyond the last of them the leaf reaches (notes/0007)
    bool is_sure;    ///< the surface ends there: points at random would hardly leave so much empty
};

/// last: how far n covered points reach there, over rho.
LeafEnd end_beyond(double last, double n);

}  // namespace slim
