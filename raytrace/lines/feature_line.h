#pragma once

#include "raytrace/lines/line_kind.h"
#include "slim/base/vec.h"

#include <vector>

namespace slim {

struct LinePoint {
    float x = 0, y = 0;  ///< picture, pixels; centres at +0.5
    Vec3f point;         ///< on the surface, frame of the job
    float weight = 0;    ///< |k| there, 1 / length; 0 of creases
    float evidence = 0;  ///< see crossings.h and, of creases, creases.h
    float facing = 1;    ///< of creases: N.v of the face that is turned away most, 1 to the eye
};

/// A polyline on the surface as one view sees it. A closed one does not repeat its first point.
struct FeatureLine {
    LineKind kind = LineKind::contour;
    bool closed = false;
    std::vector<LinePoint> points;
    float length = 0;     ///< on the surface, model units
    float length_px = 0;  ///< in the picture
    float strength = 0;   ///< integral of |k| over the length, dimensionless; of creases see
                          ///< creases.h

    std::size_t n_segments() const {
        return points.size() < 2 ? 0 : closed ? points.size() : points.size() - 1;
    }
    /// visit(from, to) for each segment.
    template <class Visit>
    void for_each_segment(Visit&& visit) const {
        for (std::size_t i = 0; i < n_segments(); ++i)
            visit(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
};

}  // namespace slim
