#pragma once

#include "raytrace/camera.h"

#include <string_view>

namespace slim {

/// What legends and a scale bar take of a picture, as shares of its width and height, margins
/// included; all 0: no room is kept.
struct LegendRoom {
    double right = 0;   ///< of a strip at the right
    double bottom = 0;  ///< of one below, beside the scale bar; 0: they do not fit there
    double corner_width = 0, corner_height = 0;  ///< of a corner
    /// of the lower left corner, which a scale bar takes; 0: none has it to itself
    double bar_width = 0, bar_height = 0;

    static LegendRoom strip_at_right(double share) { return {share, 0, 0, 0, 0, 0}; }
};

/// The camera that leaves room for legends and shows the points as large as that allows: as if
/// there were none where one corner stays free anyway; else beside a strip at the right or, where
/// they are at least 3 % larger then, above one at the bottom. Turntables keep the strip at the
/// right. What free_bottom keeps is not kept where the scale bar's corner stays free without.
///
/// framing        free_bottom: kept for a scale bar at the lower left; free_right is not looked at
/// throws         as framed_camera
FramedCamera framed_beside(std::string_view name, const Framed& framed, double aspect,
                           const Framing& framing, const LegendRoom& room);

/// Whether usual legends have a place beside what a camera shows of the points: most of a strip of
/// that room at the right or below, or of a corner.
bool leaves_room(const Camera& camera, const Framed& framed, double aspect, const LegendRoom& room);

/// Whether a scale bar of that room stands beside what a camera shows of the points.
bool leaves_bar_room(const Camera& camera, const Framed& framed, double aspect,
                     const LegendRoom& room);

}  // namespace slim
