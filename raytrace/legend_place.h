#pragma once

#include "raytrace/panel.h"
#include "raytrace/picture.h"

#include <limits>
#include <span>

namespace slim {

/// Where a panel may stand, in the order of preference.
/// Below: the bar lies along the lower edge.
enum class LegendPlace { right, right_top, right_bottom, left, left_top, left_bottom, below };

inline bool is_left(LegendPlace place) {
    return place >= LegendPlace::left && place <= LegendPlace::left_bottom;
}
inline bool is_top(LegendPlace place) {
    return place == LegendPlace::right_top || place == LegendPlace::left_top;
}
inline bool is_bottom(LegendPlace place) {
    return place == LegendPlace::right_bottom || place == LegendPlace::left_bottom;
}

/// Sum of an object's alpha in a box, which may reach beyond the picture.
double covered_alpha(const PixelBox& box, const Picture& object);

/// Pixels that two boxes share.
double shared_area(const PixelBox& a, const PixelBox& b);

/// The place whose panel covers the least of an object that stands over transparent, and of what
/// else is taken; the first of those that are equal. panel_at(place) is the panel's box.
template <class PanelAt>
LegendPlace least_covering(std::span<const LegendPlace> places, const Picture& object,
                           const PixelBox& taken, PanelAt&& panel_at) {
    LegendPlace best = places.front();
    double least = std::numeric_limits<double>::infinity();
    for (const LegendPlace place : places) {
        const PixelBox panel = panel_at(place);
        const double covered = covered_alpha(panel, object) + shared_area(panel, taken);
        if (covered < least) best = place, least = covered;
    }
    return best;
}

}  // namespace slim
