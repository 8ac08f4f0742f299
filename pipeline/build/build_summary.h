#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// RMS of the distances at the leaves' fits, each point counted in every leaf that holds it, as a
/// share of the diagonal L; 0 without leaves. (`slim measure` projects every point onto the blended
/// surface.)
double leaf_error_rms(const std::string& model);

/// Diagonal of the box of what pictures show of a model (drawn_bounds).
double drawn_diagonal(const std::string& model);

/// What a build came to, in a few lines for people, with the commands that may come next. `result`
/// is run_build's, with all counters.
std::string build_summary(const std::string& model, const std::vector<std::string>& clouds,
                          const nlohmann::json& result);

}  // namespace slim
