#pragma once

#include "pipeline/render/render_config.h"

namespace slim {

/// Checks each value that can be wrong in itself, whatever the other options are. ConfigError with
/// the key.
void check_values(const RenderConfig& config);

/// All that can be told of a picture's options without a model and without a file, those of
/// config.aov among them: what slim-render and readers of jobs both call, so that a job is refused
/// before anything is built. What a model must have for them is not looked at, nor the output.
///
/// throws  ConfigError with the key
/// cost    a few cameras
void check_options(const RenderConfig& config);

}  // namespace slim
