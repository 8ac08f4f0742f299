#pragma once

#include "slim/model/surfel.h"

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

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

/// A place where three sheets of a surfel or more meet, relative to the centre, over rho.
struct LeafCorner {
    Vec3d x;
    unsigned sheets = 0;  ///< bit k: sheet k

    bool is_of(const SheetPair& pair) const {
        return (sheets >> pair.a & sheets >> pair.b & 1u) != 0;
    }
};

/// The corners on the joined surface within the ball of a surfel of three sheets or more: of three
/// sheets one at most, of more the end of a bar has two or four. Where more than three sheets meet,
/// the place nearest to all of them. By Newton's steps from the centre for each three sheets.
std::vector<LeafCorner> corners_of(const Surfel& s);

/// Whether an edge point x of a pair is on the joined surface: not cut off by another sheet.
bool edge_shows(const Surfel& s, const SheetPair& pair, const Vec3d& x);

}  // namespace slim
