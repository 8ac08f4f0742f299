#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace slim {

/// What `slim info` says of files of ours that are neither models, clouds nor JSON, by their first
/// bytes and names: pictures (PNG, EXR: size, channels, what they say of how they were made),
/// truths, drawings, jobs, pages, lines in space (OBJ), tables (CSV), what `slim plan` prints
/// ("workflow"), logs, each with counts. Nothing for any other file.
///
/// returns  kind, bytes, about (a sentence), and of pictures width, height, channels, metadata; of
///          a truth points, and cloud, the file that it lies beside
/// throws   FormatError for a picture, a truth or a table that is damaged, ConfigError for text
///          that is no TOML, IoError
std::optional<nlohmann::json> other_info(const std::string& path);

}  // namespace slim
