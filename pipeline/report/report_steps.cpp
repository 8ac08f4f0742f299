#include "pipeline/report/report_steps.h"

#include "formats/atomic_file.h"
#include "pipeline/child_process.h"
#include "pipeline/json_text.h"
#include "pipeline/report/report_cloud.h"
#include "pipeline/report/report_record.h"
#include "pipeline/report/report_step_output.h"
#include "pipeline/report/report_text.h"
#include "pipeline/report/report_times.h"
#include "pipeline/run_started.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool is_verb(const ReportStep& step) { return !is_made_here(step) && step.run != "command"; }

}  // namespace

StepRunner::StepRunner(StepSettings settings, StageContext& context)
    : settings_(std::move(settings)),
      context_(context),
      planner_(settings_, context.threads),
      started_(run_started()) {
    hand_on_run_started();
}

StepRecord StepRunner::run_program(const ReportStep& step, const PlannedStep& planned) {
    StepRecord record;
    std::vector<std::string> command;
    if (is_verb(step)) {
        command = {planned.program, "--json", "--quiet", "--force",
                   fmt::format("--threads={}", context_.threads)};
    } else {
        command = {planned.program};
    }
    command.insert(command.end(), planned.words.begin(), planned.words.end());
    if (is_verb(step) && !planned.output.empty())
        command.insert(command.end(), {"-o", planned.output});
    const std::string log = (settings_.folder / (planned.name + ".log")).string();
    StepTimes times;
    ChildResult child;
    for (int i = 0; i < step.repeat; ++i) {
        child = run_child(command, log);
        context_.check_stop();
        times.seconds.push_back(child.seconds);
        times.processor.push_back(child.processor_seconds);
        if (child.exit_code != 0) break;
    }
    record.figures = object_in(child.output);
    std::ifstream written(planned.output);
    if (step.out.ends_with(".json") && record.figures.empty())
        record.figures = json_or_discarded(written);
    if (!record.figures.is_object()) record.figures = json::object();
    if (record.figures.contains("error"))
        record.reason = record.figures["error"].value("message", "");
    times.put(record.figures);
    put_warnings(log, record.figures);
    record.figures["exit"] = child.exit_code;
    record.figures["peak_memory_bytes"] = child.peak_memory_bytes;
    record.figures["bytes_read"] = child.bytes_read;
    return record;
}

/// A step that this process does itself.
StepRecord StepRunner::made(const ReportStep& step, const ReportRow& row,
                            const PlannedStep& planned) {
    StepRecord record;
    record.figures = json::object();
    record.figures["exit"] = 0;
    try {
        if (step.run == "cloud")
            record.figures.update(make_cloud(planned.from, planned.points, step.point, row.lookup(),
                                             settings_.seed, step.single, planned.output));
        else
            write_file_atomically(planned.output, filled(step.text, row.lookup(), 17, step.where));
    } catch (const Error& error) {
        record.reason = error.what();
        record.figures["exit"] = static_cast<int>(error.code());
    }
    return record;
}

StepRecord StepRunner::executed(const ReportStep& step, const ReportRow& row,
                                const PlannedStep& planned) {
    StepRecord record = is_made_here(step) ? made(step, row, planned) : run_program(step, planned);
    const int code = record.figures.value("exit", 0);
    record.reason = replaced(record.reason, settings_.folder.string() + "/", "");
    record.figures["message"] = record.reason;
    record.done = step.expects(code);
    if (!record.done)
        record.reason = fmt::format("ended with {}{}{}", code, record.reason.empty() ? "" : ": ",
                                    record.reason);
    record.step = step.name, record.run = step.run;
    record.name = planned.name, record.output = planned.output;
    record.run_started = started_;
    return record;
}

/// Makes anew what a transient step of the row has taken away and this one reads.
void StepRunner::make_inputs(const Experiment& experiment, const ReportRow& row,
                             const PlannedStep& planned) {
    for (const auto* words : {&planned.words, &planned.from})
        for (const std::string& word : *words)
            for (std::size_t i = 0; i < row.steps.size(); ++i) {
                if (word != row.steps[i].output || fs::exists(word)) continue;
                const auto step = std::find_if(
                    experiment.steps.begin(), experiment.steps.end(),
                    [&](const ReportStep& s) { return s.name == row.steps[i].step; });
                const PlannedStep again = planner_.plan(*step, row);
                make_inputs(experiment, row, again);
                executed(*step, row, again);
            }
}

StepRecord StepRunner::done(const Experiment& experiment, const ReportStep& step,
                            const ReportRow& row) {
    const PlannedStep planned = planner_.plan(step, row);
    if (!planned.missing.empty()) {
        StepRecord record;
        record.step = step.name, record.run = step.run;
        record.absent = true, record.reason = planned.missing;
        return record;
    }
    if (!context_.force)
        if (auto known = read_record(settings_.folder, step, planned.name, planned.output)) {
            ++n_reused_;
            return *known;
        }
    context_.reporter.info(
        fmt::format("{}: {}, {}", experiment.name, row.label(experiment), step.name));
    make_inputs(experiment, row, planned);
    StepRecord record = executed(step, row, planned);
    ++n_run_;
    if (record.done || step.may_fail) write_record(settings_.folder, record);
    return record;
}

void StepRunner::run(const Experiment& experiment, ReportRow& row) {
    for (const ReportStep& step : experiment.steps) {
        context_.check_stop();
        try {
            if (!row.is_meant(step.when)) continue;
        } catch (const MissingFigure&) {
            continue;
        }
        row.steps.push_back(done(experiment, step, row));
    }
    for (const ReportStep& step : experiment.steps)
        if (const StepRecord* record = step.transient ? row.step(step.name) : nullptr;
            record && !record->name.empty())
            for (const fs::path& file : files_of_step(settings_.folder, record->name))
                fs::remove(file);
}

}  // namespace slim
