#pragma once

#include "pipeline/render/render_config.h"

#include <optional>

namespace slim {

/// The spacing of --contours: 0 for none, empty for auto. ConfigError if it is no such thing.
std::optional<double> fixed_spacing(const RenderConfig& config);

/// Checks --contours and --sun (ConfigError).
void check_relief(const RenderConfig& config);

}  // namespace slim
