#pragma once

#include "pipeline/report/report_file.h"

#include <string>
#include <utility>
#include <vector>

namespace slim {

/// Throws ConfigError, with the place and the nearest name, if a formula of an experiment names
/// what no row can have: neither a parameter, a value of the file, `seed` nor a step.
void check_formulas(const Experiment& experiment,
                    const std::vector<std::pair<std::string, FigureValue>>& values);

}  // namespace slim
