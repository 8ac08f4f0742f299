#pragma once

#include "pipeline/render/render_config.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace slim {

/// What a person wants to know of a render's result: files, size, scale, ranges of maps, time.
/// Counts of tests and nodes are for --json and -v.
std::string render_summary(const RenderConfig& config, const nlohmann::json& result);

}  // namespace slim
