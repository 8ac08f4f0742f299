#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "raytrace/height_label.h"
#include "raytrace/picture.h"
#include "raytrace/shade.h"

#include <array>
#include <cstdint>
#include <span>

namespace slim {

/// Light and lines of a relief map. Directions are in the world.
struct Relief {
    std::array<Vec3f, 3> axes;  ///< east, up and south, unit
    double base = 0;            ///< height of the frame's origin in the world
    double azimuth_deg = 315;   ///< of the sun, clockwise from north
    double altitude_deg = 45;   ///< of the sun over the horizon
    double spacing = 0;         ///< of the contour lines, model units; 0: none
    int index_every = 5;        ///< each so many lines is a heavier one, counted from height 0
};

/// Spacing of the form {1, 2, 5} * 10^k that makes about 20 contour lines of the heights between
/// `low` and `high`; 0 if these are equal.
double contour_spacing(double low, double high);

/// The contour lines of a relief among some heights.
struct ContourLevels {
    double spacing = 0, heavy_spacing = 0;  ///< as asked for, whether or not there are lines
    double low = 0, high = 0;     ///< heights in the world, both included
    /// how many lines lie there, and of these the heavier ones; 1e15 at most
    std::int64_t lines = 0, heavy = 0;
};
ContourLevels contour_levels(const Relief& relief, double low, double high);

/// Relief shading in grey (the cosine to the sun over a soft ambient) with contour lines in brown,
/// of rows of a frame that holds normals, and positions for contour lines.
///
/// Lines are one pixel of a picture 1000 high wide, heavier ones two, whatever the slope: a pixel's
/// distance to the next line is its height over the change to the pixels beside it on the same
/// surface, on the tangent plane where there is none. Lines closer than they are wide become a
/// tone. No pixel looks farther than at those beside it; parts of a picture that hold these agree.
/// view        of the whole picture, of which the frame may be a part (as `shade` says)
/// line_width  pixels of the frame
/// labels      heights that will be written, for which lines leave gaps; in pixels of a picture
///             whose pixels are `factor` of the frame's wide
Picture paint_relief(const GBuffer& frame, const PixelView& view, const ShadeView& shade,
                     const RowRange& rows, const Relief& relief, float line_width,
                     std::span<const HeightLabel> labels = {}, int factor = 1);

/// Heights of the frame's hits that `percent` and 100 - `percent` of them lie below; equal without
/// any.
std::array<double, 2> height_span(const GBuffer& frame, const Relief& relief, double percent);

}  // namespace slim
