#pragma once

#include "pipeline/report/report_results.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// Everything that a report shows.
struct Report {
    std::vector<ReportFile> files;
    std::vector<std::vector<ExperimentResult>> results;  ///< of each file's experiments
    nlohmann::json provenance;                           ///< version, machine, threads, seed,
                                                         ///< configurations

    /// All checks and verdicts of cases, in order.
    std::vector<const CheckResult*> checks() const;
    std::size_t count(Verdict verdict) const;
};

/// What runs the report: processor, cores, memory, system. Keys in a fixed order.
nlohmann::json machine_json();

/// One self-contained HTML page: tables, plots as SVG, pictures as data; no script, no link to
/// outside, nothing to fetch. The same results give the same bytes.
std::string report_page(const Report& report);

/// The same as JSON: provenance, and of every experiment its rows, curves, checks, verdict.
nlohmann::json report_json(const Report& report);

/// An experiment's rows: a column for each parameter of the grid and each of its columns; numbers
/// exact. Where any is a time, one more: when the runs of the report began that timed the row
/// (report_times.h).
std::string rows_csv(const ExperimentResult& result);

/// A page's beginning up to <body>, with the style that all our pages have.
std::string page_head(const std::string& title);

}  // namespace slim
