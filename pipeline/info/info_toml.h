#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// What `slim info` says of a TOML file: of a job (kind "job") its tables input, scan, fit, render,
/// measure and output as the file has them and a view_list with the name and aovs of each; of a
/// report its experiment_names; of options for --config the keys that it names.
///
/// throws   ConfigError if it is no TOML, naming the line; nothing is checked against the verbs
nlohmann::json toml_info(const std::string& path);

/// The same for a person: a line for what the file asks for, as few words as say it.
nlohmann::json toml_in_short(nlohmann::json info);

}  // namespace slim
