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

/// What a panel in a box hides: the object's alpha, and of another panel as much as would outweigh
/// all of the object, for words over words are not read.
double hidden_by(const PixelBox& box, const Picture& object, const PixelBox& taken);

/// The place whose panel hides the least of an object that stands over transparent and of another
/// panel (hidden_by); the first of those that are equal. panel_at(place) is the panel's box.
template <class PanelAt>
LegendPlace least_covering(std::span<const LegendPlace> places, const Picture& object,
                           const PixelBox& taken, PanelAt&& panel_at) {
    LegendPlace best = places.front();
    double least = std::numeric_limits<double>::infinity();
    for (const LegendPlace place : places) {
        const double hidden = hidden_by(panel_at(place), object, taken);
        if (hidden < least) best = place, least = hidden;
    }
    return best;
}

}  // namespace slim
