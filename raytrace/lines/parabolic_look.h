#pragma once

#include "raytrace/lines/crest_look.h"
#include "raytrace/lines/feature_line.h"

#include <span>

namespace slim {

/// Fills in the evidence of parabolic lines: how high the shape stands out on either side over what
/// the fit leaves open, dimensionless.
///
/// Across a line, the curvature that vanishes there, k, goes on with one sign over a way d, until
/// the other one takes half of its turn back. As half a wave of that length it is int k ds d / (2
/// pi) high; the evidence is that over the surfels' RMS residual, or 1e-5 of L where they have
/// less, the lesser of both sides. A side that ends before that (limb, border, another sheet) shows
/// too little: it counts where the other one does as well, and then the greater. Means over 61
/// points of the line (at px 1).
///
/// px      a pixel of a picture 1000 high, in pixels; 1 at least
/// cost    O(points x log of the picture's size)
void look_across_parabolic(std::span<FeatureLine> lines, const CurvatureSamples& samples,
                           double diagonal, float px);

}  // namespace slim
