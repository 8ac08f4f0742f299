#pragma once

#include "pipeline/render/render_config.h"
#include "slim/base/vec.h"

namespace slim {

/// --offset, where the origin of --truth-shape lies in the world. ConfigError unless it is three
/// numbers.
Vec3d shape_offset(const RenderConfig& config);

/// Checks --truth-shape and --offset (ConfigError).
void check_truth(const RenderConfig& config);

}  // namespace slim
