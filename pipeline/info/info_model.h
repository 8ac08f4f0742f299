#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// What `slim info` says of a model: counts, bounds, leaves by level and degree, provenance,
/// health. Reads all of it.
/// throws as ModelFile::open; FormatError for a provenance that no model of this program has
nlohmann::json model_info(const std::string& path);

/// The same for a person: leaves that are not as asked and points left out by what that means, in
/// place of the names of their counts, those that there are.
nlohmann::json model_in_short(nlohmann::json info);

}  // namespace slim
