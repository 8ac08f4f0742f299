#pragma once

#include "pipeline/report_row.h"
#include "pipeline/stage.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace slim {

/// How the steps of a report are run.
struct StepSettings {
    std::filesystem::path folder;         ///< for outputs and records; must exist
    std::uint64_t seed = 1;
    std::vector<std::string> programs;    ///< folders to look for commands in, before PATH
};

/// Runs the steps of rows, one child process each, and keeps a record of every one:
/// NAME-HASH.step.json beside its outputs NAME-HASH.*. The hash is of all that decides what comes
/// out: verb, words (with the hashes of the steps whose outputs they name, and of the bytes of
/// other files), program version and bytes, threads. So a step that two rows or experiments ask for
/// is run once, and a report that was stopped goes on where it was. A record whose outputs are not
/// as it says is run again; a step that failed where it must not is not recorded.
class StepRunner {
public:
    StepRunner(StepSettings settings, StageContext& context);

    /// Runs all steps for a row in order and adds what they came to. throws Interrupted; IoError;
    /// ConfigError
    void run(const Experiment& experiment, ReportRow& row);
    std::size_t n_run() const { return n_run_; }
    std::size_t n_reused() const { return n_reused_; }

private:
    struct Planned;
    Planned plan(const ReportStep& step, const ReportRow& row);
    StepRecord done(const Experiment& experiment, const ReportStep& step, const ReportRow& row);
    StepRecord executed(const ReportStep& step, const ReportRow& row, const Planned& planned);
    StepRecord made(const ReportStep& step, const ReportRow& row, const Planned& planned);
    StepRecord run_program(const ReportStep& step, const Planned& planned);
    void make_inputs(const Experiment& experiment, const ReportRow& row, const Planned& planned);
    std::string program_path(const std::string& name) const;
    std::string hash_of(const std::string& file);

    StepSettings settings_;
    StageContext& context_;
    std::string started_;  // of this run of the report
    std::map<std::string, std::string> hashes_;  // of files outside the folder
    std::size_t n_run_ = 0, n_reused_ = 0;
};

}  // namespace slim
