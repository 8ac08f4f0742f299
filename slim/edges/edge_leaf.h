#pragma once

#include "slim/model/surfel.h"

#include <array>
#include <cstddef>
#include <optional>

namespace slim {

/// Two sheets of a sharp surfel: one edge of it.
struct SheetPair {
    std::size_t a, b;
};
/// Pairs of n sheets.
constexpr std::size_t n_pairs(std::size_t n) { return n * (n - 1) / 2; }
/// Those of fewer sheets first: {0, 1}, {0, 2}, {1, 2}, {0, 3}, ...
inline constexpr auto kSheetPairs = [] {
    std::array<SheetPair, n_pairs(kMostSheets)> pairs{};
    std::size_t n = 0;
    for (std::size_t b = 1; b < kMostSheets; ++b)
        for (std::size_t a = 0; a < b; ++a) pairs[n++] = {a, b};
    return pairs;
}();

/// Edges that a sharp surfel may have.
inline std::size_t n_sheet_pairs(const Surfel& s) { return n_pairs(s.n_sheets()); }

/// How two sheets of a sharp surfel are joined: max at a convex edge.
inline Join join_of_pair(const SharpSheets& sheets, std::size_t pair) {
    return kSheetPairs[pair].a == 0 ? sheets.outer : sheets.inner;
}

/// The point nearest x where both sheets of a pair are 0, by Newton's steps of least length;
/// relative to the centre, over rho. Nothing where they do not meet near the ball, or at less than
/// about 6 degrees.
std::optional<Vec3d> nearest_on_edge(const Surfel& s, const SheetPair& pair, Vec3d x);

/// Where all sheets are 0, of more than three the place nearest to all, likewise, from the centre.
/// Of surfels of three sheets or more.
std::optional<Vec3d> corner_of(const Surfel& s);

/// Whether an edge point x of a pair is on the joined surface: not cut off by another sheet.
bool edge_shows(const Surfel& s, const SheetPair& pair, const Vec3d& x);

}  // namespace slim
