#pragma once

#include "pipeline/report/report_results.h"

#include <string>
#include <vector>

namespace slim {

/// Whether a time in the formula was taken before the last run of the report.
bool is_earlier(const Expression& formula, const ReportRow& row, const std::string& last_run);

/// Tables as HTML; empty where there is nothing to show. Of a plot its curves' slopes, those of
/// theory, and where they break.
std::string slope_table(const PlotResult& result);

/// An experiment's rows, folded where there are many, and the steps without a result.
std::string rows_table(const ExperimentResult& result, const std::string& last_run);

/// Bands, open where one failed.
std::string checks_table(const std::vector<CheckResult>& checks);

/// The experiments that are cases, one a row.
std::string cases_table(const std::vector<ExperimentResult>& results);

}  // namespace slim
