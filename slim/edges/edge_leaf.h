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
inline constexpr std::array<SheetPair, 3> kSheetPairs{{{0, 1}, {0, 2}, {1, 2}}};

/// Edges that a sharp surfel may have.
inline std::size_t n_sheet_pairs(const Surfel& s) { return s.n_sheets() == 2 ? 1 : 3; }

/// How two sheets of a sharp surfel are joined: max at a convex edge.
inline Join join_of_pair(const SharpSheets& sheets, std::size_t pair) {
    return sheets.n_extra == 2 && pair == 2 ? sheets.inner : sheets.outer;
}

/// The point nearest x where both sheets of a pair are 0, by Newton's steps of least length;
/// relative to the centre, over rho. Nothing where they do not meet near the ball, or at less than
/// about 6 degrees.
std::optional<Vec3d> nearest_on_edge(const Surfel& s, const SheetPair& pair, Vec3d x);

/// Where all three sheets are 0, likewise, from the centre. Of surfels of three sheets.
std::optional<Vec3d> corner_of(const Surfel& s);

/// Whether an edge point x of a pair is on the joined surface: not cut off by the third sheet.
bool edge_shows(const Surfel& s, const SheetPair& pair, const Vec3d& x);

}  // namespace slim
