#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "slim/shapes/shape.h"

#include <vector>

namespace slim::bench {

/// A short piece of a crest line as a view shows it.
struct CrestSample {
    bool ridge = true;
    double x = 0, y = 0;    ///< picture, pixels
    double px = 0;          ///< its length in the picture
    double sharpness = 0;   ///< -k''/k^3 that makes k fall as it does until the
                            ///< normal turns by 40 degrees to either side
};

/// What each pixel's centre sees of a closed shape, exact: positions, normals, k1, k2, t1, e1 and
/// e2 (differences of the exact curvature over 1e-3 of the diagonal, error about 1e-6). Planes as
/// line_channels wants them for crest lines.
GBuffer exact_buffer(const Shape& shape, const PixelView& view, int width, int height);

/// The visible crest lines by their definition: zeros of e1 along t1 where k1 > |k2| is greatest
/// (ridges), those of e2 along t2 where -k2 > |k1| is greatest (valleys), each found on the surface
/// between two neighbouring pixels by bisection. No blur and no threshold, but for the sign of the
/// slope of e on both sides. cost O(pixels), parallel
std::vector<CrestSample> exact_crest_lines(const Shape& shape, const PixelView& view,
                                           const GBuffer& exact);

}  // namespace slim::bench
