#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// What `slim info` says of a cloud: format, counts, bounds, attributes, health.
/// Reads all of it, in chunks. A PLY of lines in space is of the kind "lines", with its edges; what
/// `slim measure --per-point` wrote says so. throws as open_cloud
nlohmann::json cloud_info(const std::string& path, StageContext& context);

}  // namespace slim
