#pragma once

#include "pipeline/report/report_file.h"
#include "pipeline/report/report_row.h"

#include <string>
#include <utility>
#include <vector>

namespace slim {

/// Throws ConfigError, with the place and the nearest name, if a formula of an experiment names
/// what no row can have: neither a parameter, a value of the file, `seed` nor a step.
void check_formulas(const Experiment& experiment,
                    const std::vector<std::pair<std::string, FigureValue>>& values);

/// After the rows were run: throws ConfigError, with the nearest, for a column that names a result
/// which its step printed in no row, though it ended well in one.
void check_columns(const Experiment& experiment, const std::vector<ReportRow>& rows);

}  // namespace slim
