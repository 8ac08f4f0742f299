#pragma once

#include "slim/cover/surfel_fit.h"

#include <cstdint>

namespace slim {

/// Over the usual radius: a region so thin is a surface or strays.
inline constexpr double kSparse = 4;
inline constexpr std::uint32_t kFewest = 3;  ///< points that any leaf may have

/// Whether a leaf's points are no surface of its size: a pole, a twig, the crown of a tree, a clump
/// in the midst of its ball. A disc among them would stand in the air.
/// sparse: the finest ball with enough points is far larger than the cloud's usual one; clean: the
/// cloud has neither contrary normals nor much noise, whose leaves may be as thick as points at
/// random (notes/0011).
bool is_scatter(const CoveringSurfel& leaf, bool forced, bool sparse, bool clean);

/// Whether a leaf's points are a line and, as the cloud is dense both ways elsewhere, no scan line
/// with others beside it: a wire. Too large, if there are more than 15 of them: in a larger ball
/// the line has more points, but no more breadth.
bool is_wire(const CoveringSurfel& leaf);
bool is_too_large_on_wire(const CoveringSurfel& leaf);

/// Of its cases the one that a leaf is too thick, by more than a factor:
/// of a fit to some of its points.
bool is_thicker(const CoveringSurfel& leaf, bool forced, bool sparse, bool clean, double factor);

/// Share of its radius, from 0.1 to 1, that a leaf of 2 to 7 covered points asks for: 1.15 times
/// the farthest of them in its tangent plane. 1 of all others.
double share_of_few(const CoveringSurfel& leaf);

/// Whether a small leaf of a noisy cloud says less of its points than a surface beside them does:
/// forced with up to 25 points, or up to 60 that fill a volume (eps above 0.12 rho), where
/// sqrt(lambda) is above 0.07 rho; or up to 200 points that are two sheets (eps above 0.2 rho),
/// where it is above 0.04 rho. At rims, where the scanner sees a surface at a grazing angle, each
/// gets its own direction, and they stand out like scales (notes/0003).
bool is_doubtful(const FittedSurfel& leaf, double noise_variance);

/// The first of these cases by the points of a forced ball alone: no fit is needed to know it.
bool are_few_in_noise(std::size_t n_points, double radius, double noise_variance);
inline constexpr std::size_t kFewOfForced = 25;  ///< points that such a ball has at most

}  // namespace slim
