#pragma once

#include "pipeline/render_config.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

namespace slim {

/// Draws a model: pictures of what is asked (config.aov), each file whole or not at all.
///
/// returns  files, width, height, covered_pixels, surfels_drawn, nodes_visited, root_tests,
///          distance_tests, unblended_pixels, frame_ms_median (projection and shading, no files; the
///          median of config.repeat frames), ranges {aov: [lo, hi]} of the maps, lines {kind:
///          {polylines, length, length_px, strength}} if asked for; with --mode raytrace
///          light_rays (all but the primary ones) and scene_ms (the tree over the surfels, once)
/// throws   ConfigError (exit 2), FormatError, IoError, DataError for a model without surfels (3),
///          NumericalError if not one pixel is hit (5), naming the camera and the model's bounds
/// Up to date (see Stamp) means: nothing is drawn, unless a time is asked for (repeat > 1).
nlohmann::json run_render(const RenderConfig& config, StageContext& context);

}  // namespace slim
