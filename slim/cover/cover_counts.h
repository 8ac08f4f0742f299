#pragma once

#include "slim/cover/surfel_fit.h"
#include "slim/model/surfel.h"

#include <array>
#include <cstdint>

namespace slim {

/// What is counted of a leaf and a model does not keep.
struct LeafCount {
    Fallback fallback;
    bool normals_disagree, two_layers;
};

LeafCount count_of(const CoveringSurfel& leaf);

/// Counts of what happened, each fallback by cause.
struct CoverCounts {
    std::uint64_t leaves = 0, internals = 0, levels = 0;
    std::uint64_t saturated = 0, forced = 0, normals_disagree = 0;
    std::uint64_t contrary = 0;     ///< leaves whose ball ends at normals of
                                    ///< a fold or another sheet
    std::uint64_t two_layers = 0;   ///< leaves that run between two layers of points (two_layers.h)
    std::uint64_t unexplained = 0;  ///< points that no surfel explains, not even their own: dropped
    std::uint64_t beside = 0;       ///< points of rims, left to the surface beside them: dropped
    std::uint64_t isolated = 0;     ///< strays, with too few neighbours about rho_0: dropped
    std::uint64_t sharp_edges = 0, sharp_corners = 0;  ///< leaves of two sheets, and of more
    std::uint64_t sharp_rungs = 0;  ///< balls that were tried with more than one sheet
    std::uint64_t needless = 0;     ///< leaves taken away again, as others do without them
    std::uint64_t refitted = 0;     ///< leaves moved by the second fit (those of the halo too)
    std::uint64_t own = 0;          ///< leaves of single points that all others passed by, some of
                                    ///< them unexplained or beside
    std::uint64_t gaps = 0;         ///< leaves that close gaps between the others
    std::uint64_t recentred = 0;    ///< leaves of border points, moved inwards
    std::uint64_t evaluated = 0, discarded = 0, rungs = 0, refinements = 0, point_visits = 0;
    std::array<std::uint64_t, kFallbacks> fallbacks{};
    std::array<std::uint64_t, kMaxDegree + 1> degrees{};

    /// Adds a leaf by its flags, sheets, degree and fallback.
    void add_leaf(const CoveringSurfel& leaf);
    /// Takes back what add_leaf() and the limited ones' count added, of a leaf that is needless.
    void take_back(const FittedSurfel& leaf, const LeafCount& count);
    CoverCounts& operator+=(const CoverCounts& b);
};

}  // namespace slim
