#pragma once

#include "raytrace/lines/feature_line.h"

#include <vector>

namespace slim {

/// Which lines of a kind are worth drawing.
struct LineRules {
    float least_evidence = 0;   ///< a crossing with less ends a line
    float strong_evidence = 0;  ///< mean over a line's length that it must reach
    float strength = 0;         ///< a line at least this strong is drawn
    float weak_strength = 0;    ///< and one this strong that continues a drawn one
    float least_px = 4;         ///< length in the picture
    float weak_px = 4;          ///< the same of one that continues a drawn one
    /// Whether a weak line continues drawn ones if both its ends meet some, anywhere,
    /// or if one end meets an end.
    bool meets_anywhere = false;
    /// Strength times mean evidence that a drawn line must reach: of crest lines the integral of
    /// -k''/k^2, up to which the fit of a noisy cloud makes some of its own.
    float sharpness = 0;
    /// A loop shorter than that, in the picture, is drawn if it is at least so strong.
    float loop_px = 0, loop_strength = 0;
};

/// A pixel of a picture 1000 high, in pixels; 1 at least.
float line_pixel(int picture_width, int picture_height);

/// The rules as found on scans (raytrace/lines/notes/0001). Lengths are those of a picture 1000
/// pixels high and grow with it.
LineRules line_rules(LineKind kind, int picture_width, int picture_height);

/// Length, length in the picture and strength, of creases their mean turn, from the points.
void measure_line(FeatureLine& line);

/// Cuts lines where the evidence falls short and keeps the pieces by the rules, hysteresis
/// included: a weak line stays if one of its ends lies within 3 pixels of an end of a line that
/// stays, or, where the rules say so, if both lie as near to any points of such lines. cost
/// O(points), while ends do not crowd
std::vector<FeatureLine> select_lines(std::vector<FeatureLine> lines, const LineRules& rules);

/// Moves points towards the mean of their neighbours, in the picture and in space alike; ends of
/// open lines stay. Takes the steps of the pixel grid out, which are below half a pixel.
void smooth_line(FeatureLine& line, int passes);

}  // namespace slim
