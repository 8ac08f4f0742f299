#pragma once

#include "pipeline/render/render_config.h"
#include "slim/base/vec.h"

#include <optional>
#include <string>
#include <vector>

namespace slim {

/// What of a picture's options can be wrong whatever the model is: told before any work, of a job
/// before the build. `aovs`: those of the picture, in place of config.aov.
///
/// throws  ConfigError naming the key
void check_options(const RenderConfig& config, const std::vector<std::string>& aovs);

/// The spacing of --contours, model units: 0 for none, empty for auto. ConfigError.
std::optional<double> contour_spacing(const RenderConfig& config);

/// --offset, world; 0 without. ConfigError.
Vec3d shape_offset(const RenderConfig& config);

}  // namespace slim
