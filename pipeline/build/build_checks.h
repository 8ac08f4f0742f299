#pragma once

#include "pipeline/build/build_stage.h"
#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"

#include <string>

namespace slim {

/// The options of a build as those of its stages, in that work folder.
NormalsConfig normals_config(const BuildConfig& config, const std::string& work);
FitConfig fit_config(const BuildConfig& config, const std::string& work);

/// All that can be told of a build's options without its clouds: readers of jobs ask, too.
/// ConfigError with the key.
void check_build_options(const BuildConfig& config);

}  // namespace slim
