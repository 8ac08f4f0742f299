#pragma once

#include "pipeline/render/render_config.h"
#include "slim/base/bbox.h"

namespace slim {

/// Checks --truth-shape and --offset (ConfigError).
void check_truth(const RenderConfig& config);

/// Refuses what is drawn, a box of the world, where --truth-shape is nowhere near it, as slim
/// measure refuses a cloud (NumericalError): its distances would say nothing.
void refuse_far_truth(const RenderConfig& config, const Bbox& drawn);

}  // namespace slim
