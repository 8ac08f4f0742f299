#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// throws  DataError if none of the clouds has colours: asked before hours of work;
///         what opening them throws
void require_colors(const std::vector<std::string>& clouds);

/// Fits the colours of the clouds to the leaves of their model and writes it again with them: one
/// pass over the clouds, 65,536 points at a time.
///
/// returns  colored_points, and lost ones in no leaf's ball
/// throws   DataError if no cloud has colours; what reading and writing throw. Clouds without are
///          passed over with a warning
nlohmann::json add_colors(const std::string& model, const std::vector<std::string>& clouds,
                          StageContext& context);

}  // namespace slim
