#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "slim/base/vec.h"
#include "slim/model/sharp_edge.h"

#include <cmath>
#include <cstddef>
#include <span>

namespace slim {

/// Which rows of a picture the planes of a scene hold, and which of these are searched:
/// all of both by default.
struct SceneRows {
    int top = 0;             ///< row of the picture that is the planes' first
    int height = 0;          ///< of the picture; 0: the planes'
    int begin = 0, end = 0;  ///< rows of the planes whose edges are searched; end 0: to the last
};

/// A rendered view as the search for lines sees it: positions and normals of the picture or of some
/// of its rows, frame of the job; `a` and `b` are entries of the planes, mostly of neighbours.
struct LineScene {
    const GBuffer& buffer;
    const PixelView& view;
    double diagonal = 1;  ///< L of the model, the unit of lengths without a scale of their own
    int degree = 2;       ///< of the model
    std::span<const SharpEdge> edges = {};  ///< of the model, for creases
    SceneRows rows{};

    int picture_height() const { return rows.height > 0 ? rows.height : buffer.height; }
    std::size_t first_row() const { return static_cast<std::size_t>(rows.begin); }
    std::size_t end_row() const {
        return static_cast<std::size_t>(rows.end > 0 ? rows.end : buffer.height);
    }

    bool hit(std::size_t a) const { return buffer.hit[a] != 0; }
    Vec3f point(std::size_t a) const {
        return {buffer.position[0][a], buffer.position[1][a], buffer.position[2][a]};
    }
    Vec3f normal(std::size_t a) const {
        return {buffer.normal[0][a], buffer.normal[1][a], buffer.normal[2][a]};
    }
    /// From the surface to the eye, any length.
    Vec3f toward_eye(std::size_t a) const {
        return view.orthographic ? to_float(-view.forward) : to_float(view.eye) - point(a);
    }
    /// How much deeper in the view b lies than a, model units: a difference of points, as depths
    /// themselves are rounded to the step of floats at the eye's distance.
    float deeper(std::size_t a, std::size_t b) const {
        return dot(to_float(view.forward), point(b) - point(a));
    }
    /// Width of a pixel at the surface, model units.
    float footprint(std::size_t a) const {
        if (view.orthographic) return static_cast<float>(1 / view.px_per_unit);
        return dot(to_float(view.forward), point(a) - to_float(view.eye)) /
               static_cast<float>(view.focal_px);
    }
    /// The point at the depth of a that is seen so many pixels right and down of it.
    Vec3f moved(std::size_t a, float right, float down) const {
        return point(a) +
               (to_float(view.right) * right + to_float(view.down) * down) * footprint(a);
    }
    /// Root mean square residual of the surfel seen, model units; 0 where the frame does not say.
    float fit_error(std::size_t a) const {
        return buffer.fit_error.empty() ? 0 : buffer.fit_error[a];
    }
    /// N.v, both unit.
    float facing(std::size_t a) const { return dot(normal(a), normalized(toward_eye(a))); }
};

inline constexpr float kSheetGap = 2;          ///< footprints
inline constexpr float kSheetTurn = 0.5f;      ///< N_a . N_b of one sheet is above
inline constexpr float kCreaseTurn = 0.866f;   ///< and below this at an edge
                                               ///< within a pixel: 30 degrees

/// Whether the surface breaks off between two hits beside each other: each lies off the other's
/// tangent plane by more than it can bend away in a pixel: 2 footprints, or one where N.v changes
/// its sign.
///
/// Departs from NUMERICS 5.4, which takes any depth gap above 2 footprints: so every face steeper
/// than 63 degrees would be a contour. On a sphere the last pixel before the limb lies at most one
/// footprint off the tangent plane of the one before, whatever the gap.
inline bool breaks_off(const LineScene& s, std::size_t a, std::size_t b) {
    const Vec3f d = s.point(b) - s.point(a);
    const float width = s.footprint(a), sq_gap = sq_length(d);
    if (sq_gap <= kSheetGap * kSheetGap * width * width) return false;
    const float off = std::fmax(std::fabs(dot(d, s.normal(a))), std::fabs(dot(d, s.normal(b))));
    return off > kSheetGap * width || (off > width && (s.facing(a) > 0) != (s.facing(b) > 0));
}

/// Whether two neighbours lie on one sheet without an edge between them (N_a . N_b > 0.5).
inline bool one_sheet(const LineScene& s, std::size_t a, std::size_t b) {
    return s.hit(a) && s.hit(b) && dot(s.normal(a), s.normal(b)) > kSheetTurn &&
           !breaks_off(s, a, b);
}

}  // namespace slim
