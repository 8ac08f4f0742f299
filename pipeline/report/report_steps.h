#pragma once

#include "pipeline/report/report_row.h"
#include "pipeline/report/report_step_plan.h"
#include "pipeline/stage.h"

#include <cstddef>
#include <string>

namespace slim {

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
    StepRecord done(const Experiment& experiment, const ReportStep& step, const ReportRow& row);
    StepRecord executed(const ReportStep& step, const ReportRow& row, const PlannedStep& planned);
    StepRecord made(const ReportStep& step, const ReportRow& row, const PlannedStep& planned);
    StepRecord run_program(const ReportStep& step, const PlannedStep& planned);
    void make_inputs(const Experiment& experiment, const ReportRow& row,
                     const PlannedStep& planned);

    StepSettings settings_;
    StageContext& context_;
    StepPlanner planner_;
    std::string started_;  // of this run of the report
    std::size_t n_run_ = 0, n_reused_ = 0;
};

}  // namespace slim
