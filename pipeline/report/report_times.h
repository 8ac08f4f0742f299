#pragma once

#include "pipeline/report/report_page.h"

#include <cstddef>
#include <map>
#include <set>
#include <string>

namespace slim {

/// Steps are run once and their figures kept, so that a report may hold times of different days:
/// every record says when the run that timed it began (run_started(): "2026-11-28T11:20:05Z").

/// Whether a figure of a step is a time: "seconds", "stages.fit.seconds", "frame_ms_median".
bool is_time(const std::string& figure);

/// The runs that the times in a formula are of; none if it names no time. A record that does not
/// say is of "(unknown)".
std::set<std::string> runs_timed(const Expression& formula, const ReportRow& row);
/// The same of all columns of a row.
std::set<std::string> runs_timed(const Experiment& experiment, const ReportRow& row);
/// Whether any column of the experiment is a time.
bool has_times(const Experiment& experiment);

/// Steps of the report by the run that they are of, the latest last. A step of several rows counts
/// once.
std::map<std::string, std::size_t> steps_by_run(const Report& report);

}  // namespace slim
