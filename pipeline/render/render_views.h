#pragma once

#include "pipeline/render/render_config.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

namespace slim {

/// Draws the views of the job file config.job of the model, each as a process beside this one that
/// skips what is up to date: the pictures that `slim run` would draw of this model. The job's
/// [input], [fit] and [measure] are not looked at. Options that were given (context.given) win over
/// what the job says, in every view.
///
/// returns  files, folder, steps (as of `slim run`), left_out
/// throws   ConfigError naming the option or the file and line (exit 2), also for --share and
///          --join, and for a file as the output of several views; what a view fails with, its line
///          in the job first unless it begins with an option that was given
nlohmann::json draw_views(const RenderConfig& config, StageContext& context);

}  // namespace slim
