#pragma once

#include "raytrace/canvas.h"
#include "raytrace/lines/feature_line.h"
#include "raytrace/renderer.h"
#include "raytrace/shade.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// What lines are drawn with, so that they stand out: dark on light backgrounds, light on dark
/// ones. Over a drawn surface they are dark, beside one the background's (ink_plane.h).
enum class Ink : std::uint8_t { dark, light };

/// The ink of more contrast with both ends of a background; dark where it is transparent.
Ink ink_on(const Background& background);

/// How lines look. Widths are in pixels of a picture 1000 pixels high and grow with it.
struct LineStyle {
    Vec3f srgb;         ///< display-referred
    const char* group;  ///< id of the kind's group in the SVG
};
LineStyle line_style(LineKind kind, Ink ink = Ink::dark);

/// Stroke width in pixels: contours all alike, the others by the logarithm of their strength.
float stroke_width(const FeatureLine& line, int picture_width, int picture_height);

/// The ink of lines, and at each pixel of the part that is drawn on the share of the other ink in
/// it; none: 0 at all.
struct LineInks {
    Ink ink = Ink::dark;
    std::span<const float> other = {};
};

/// Draws lines over a picture or a part of one, anti-aliased (coverage by the distance from the
/// pixel's centre to the stroke's edge), in the order given; points of the lines are in pixels of
/// the whole. The picture stays premultiplied. A plane of inks that is not of the part's size is a
/// SLIM_CHECK failure. Cost: O(points x stroke width); parallel over bands of rows.
void draw_lines(std::span<const FeatureLine> lines, const Canvas& canvas,
                const LineInks& inks = {});

/// Strength of the strongest line of the kinds wanted through each pixel, 0 where none passes: for
/// data files, so neither blurred nor widened. Row by row,
/// those of the window of a width x height picture.
std::vector<float> strength_plane(std::span<const FeatureLine> lines,
                                  std::span<const LineKind> kinds, int width, int height,
                                  const PixelWindow& window);

/// Those of the lines whose strokes may touch the window of a width x height picture,
/// in their order.
std::vector<FeatureLine> lines_within(std::span<const FeatureLine> lines, int width, int height,
                                      const PixelWindow& window);

}  // namespace slim
