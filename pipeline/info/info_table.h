#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace slim {

/// What `slim info` says of a CSV that is no cloud: as reports write it, names first, then rows of
/// as many cells, commas between them, quotes about what holds one. Nothing for a cloud: numbers,
/// or names with x, y and z.
///
/// returns  kind "table", bytes, about, rows, columns (their names)
/// throws   FormatError naming the row that has another number of cells, or ends within quotes
std::optional<nlohmann::json> table_info(const std::string& path);

}  // namespace slim
