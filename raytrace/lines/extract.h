#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/line_scene.h"

#include <span>
#include <vector>

namespace slim {

/// The feature lines of a view (NUMERICS 5.4): crossings on the edges between pixels, linked,
/// selected and smoothed; kinds in the order asked for, lines of a kind as link_crossings gives
/// them. Of kinds that are asked for together crest lines give way to creases, and each edge has
/// one stroke (one_stroke.h).
///
/// scene   a G-buffer of the whole picture with line_channels(kinds, degree)
/// cost    O(pixels) per kind, parallel; the same lines for any number of threads
/// throws  nothing; a channel that is missing is a SLIM_CHECK failure
std::vector<FeatureLine> extract_lines(const LineScene& scene, std::span<const LineKind> kinds);

}  // namespace slim
