#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace slim {

/// Options of `slim report`.
struct ReportConfig {
    std::vector<std::string> files;
    std::string output;
    std::uint64_t seed = 1;
    std::uint64_t cap = 0;
    std::vector<std::string> programs;
    std::vector<std::string> settings;  ///< --set values.KEY=VALUE

    template <class V>
    void visit(V&& field) {
        field.input("files", files,
                    "report files (TOML): experiments, as in configs/report/; or ordinary jobs, a "
                    "row each");
        field.output("output", output,
                     "folder for index.html, CSV, report.json and the steps' files");
        field("seed", seed, "of all random numbers that experiments name");
        field("cap", cap, "leave out rows of more points than this (0: none)");
        field.path("programs", programs, "folders to look for commands in, before PATH (peers)");
        field.settings(settings,
                       "a value of a report file is written values.KEY, as values.points, a key of "
                       "jobs TABLE.KEY, as fit.t_mdl");
    }
};

/// Runs the experiments of report files (docs/report.md) as child processes beside this one, each
/// step once whatever asks for it and not again if it is done, and writes DIR/index.html,
/// DIR/report.json and DIR/<file>.<experiment>.csv. A step that fails leaves its row without
/// figures and is named; the rest goes on. An ordinary job (docs/job.md) is a row of its steps'
/// figures; they are run in DIR/jobs/<its name>.
///
/// returns  index, steps_run, steps_reused, passed, failed, known_failures, not_run
/// throws   NumericalError (5) naming the figures that left their bands and the steps that failed,
///          after all is written; ConfigError as read_report_files
nlohmann::json run_report(const ReportConfig& config, StageContext& context);

}  // namespace slim
