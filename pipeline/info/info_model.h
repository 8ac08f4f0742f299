#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// What `slim info` says of a model: counts, bounds, leaves by level and degree, provenance,
/// health. Reads all of it.
/// throws as ModelFile::open; FormatError for a provenance that no model of this program has
nlohmann::json model_info(const std::string& path);

}  // namespace slim
