#pragma once

#include "pipeline/render/render_config.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

namespace slim {

/// Draws a model: pictures of what is asked (config.aov), each file whole or not at all.
///
/// returns  files, width, height (of what is wanted of the picture), covered_pixels, surfels_drawn,
///          truth_unknown_pixels (of truth_distance), nodes, nodes_visited, root_tests,
///          distance_tests, blocks_passed, surfels_cut_off (see RenderStats), unblended_pixels,
///          plane_bytes (of the frame's planes, a pixel), frame_ms_median (projection and shading,
///          no files; the median of config.repeat frames), ranges {aov: [lo, hi]} of the maps,
///          model_bytes, model_bytes_read (pages of the file, each counted once, however many
///          pictures show it; of colours only for the aov color), model_nodes_checked (nodes
///          checked by themselves, once each; 0 where the whole surface was checked),
///          lines {kind: {polylines, length, length_px, strength}} if asked for;
///          orthographic: pixel_size; of a turntable or path: frames, film_commands;
///          of the aov all: left_out
/// throws   ConfigError (exit 2), FormatError, IoError, DataError for a model without surfels (3),
///          NumericalError if not one pixel is hit (5), naming the camera and the model's bounds
/// Up to date (see Stamp) means: nothing is drawn, unless a time is asked for (repeat > 1).
nlohmann::json run_render(const RenderConfig& config, StageContext& context);

}  // namespace slim
