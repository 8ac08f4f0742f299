#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// What `slim info` says of a JSON file: which of ours it is, by what it holds.
///
/// returns  kind (manifest, plan, scans, report, step, result; json: another), bytes, about, counts
///          (inputs and outputs of a manifest, slices and points of a plan, scans, experiments and
///          rows of a report), and contents
/// throws   FormatError with the byte where it is no JSON
nlohmann::json record_info(const std::string& path);

}  // namespace slim
