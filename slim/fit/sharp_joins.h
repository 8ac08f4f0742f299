#pragma once

#include "slim/model/sharp_sheets.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace slim {

/// Heights of a point over each of some sheets.
using SheetHeights = std::array<double, kMostSheets>;

/// A way to join sheets, F = outer(f_first, inner(the others)).
struct WayToJoin {
    std::size_t first = 0;
    Join outer = Join::max, inner = Join::max;
};

/// Sum of squared F over the points that belong to a sheet (not 0 in `sheets`); as soon as it is no
/// less than `least`, what it is by then.
inline double misfit(const WayToJoin& way, std::size_t n_sheets,
                     std::span<const SheetHeights> heights, std::span<const std::uint8_t> sheets,
                     double least) {
    SharpSheets joins;
    joins.n_extra = n_sheets - 1;
    joins.outer = way.outer;
    joins.inner = way.inner;
    double sum = 0;
    for (std::size_t i = 0; i < heights.size() && sum < least; ++i) {
        if (!sheets[i]) continue;
        SheetHeights f = heights[i];
        std::swap(f[0], f[way.first]);
        sum += std::pow(joins.joined(f), 2);
    }
    return sum;
}

/// The way to join that the points follow best; of three sheets or more the one that is unlike goes
/// first. Sides of single sheets would not do: a face with a notch lies on both sides of the
/// notch's walls. Cost: two passes over the heights of two sheets, two and two a sheet of more, few
/// of them to the end.
inline WayToJoin best_way_to_join(std::size_t n_sheets, std::span<const SheetHeights> heights,
                                  std::span<const std::uint8_t> sheets) {
    double least = INFINITY;
    WayToJoin best;
    const std::size_t n_first = n_sheets == 2 ? 1 : n_sheets;
    for (std::size_t first = 0; first < n_first; ++first)
        for (const Join outer : {Join::max, Join::min})
            for (const Join inner : {Join::max, Join::min}) {
                const bool symmetric = outer == inner;
                if (symmetric ? first > 0 : n_sheets == 2) continue;
                const WayToJoin way{first, outer, inner};
                const double sum = misfit(way, n_sheets, heights, sheets, least);
                if (!(sum < least)) continue;
                least = sum;
                best = way;
            }
    return best;
}

}  // namespace slim
