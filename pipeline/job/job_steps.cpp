#include "pipeline/job/job_steps.h"

#include "pipeline/child_process.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/run_started.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The parts of a fault that a step's own answer has beside its message.
Fault fault_in(const json& error) {
    return {.file = error.value("file", ""),
            .line = error.value("line", 0),
            .said_by = error.value("said_by", ""),
            .key = error.value("key", ""),
            .option = error.value("option", ""),
            .expected = error.value("expected", ""),
            .found = error.value("found", ""),
            .hint = error.value("hint", "")};
}

[[noreturn]] void fail(const JobStep& step, const ChildResult& child) {
    const json answer = json_or_discarded(child.output);
    std::string reason = fmt::format("exit code {}", child.exit_code);
    Fault fault;
    if (answer.is_object() && answer.contains("error")) {
        reason = answer.at("error").value("message", reason);
        fault = fault_in(answer.at("error"));
    }
    if (child.exit_code == 137)
        throw ResourceError(step.name + ": ended by the system, which had no memory left");
    const bool known = child.exit_code <= 6 || child.exit_code == 75 || child.exit_code == 130 ||
                       child.exit_code == 143;
    const auto code = known ? static_cast<ExitCode>(child.exit_code) : ExitCode::internal;
    throw StepError(code, step.name, reason, fault);
}

/// What a manifest says that the work cost; null if it says nothing.
json cost_in(const fs::path& manifest) {
    std::ifstream in(manifest);
    try {
        const json read = json_or_discarded(in);
        return read.is_object() ? recorded_cost(read) : json();
    } catch (const json::exception&) {
        return {};
    }
}

StepOutcome outcome_of(const JobStep& step, const ChildResult& child) {
    json result = json_or_discarded(child.output);
    if (!result.is_object())
        throw InternalError(fmt::format("{}: expected one JSON object, found '{}'", step.name,
                                        child.output.substr(0, 200)));
    StepOutcome outcome{step, std::move(result), false, child.seconds,
                        static_cast<double>(child.peak_memory_bytes)};
    outcome.up_to_date = outcome.result.value("up_to_date", false);
    // The manifest's figures in either case: the child's own time has its start and end in it.
    if (const json recorded = cost_in(step.target); !recorded.is_null()) {
        outcome.seconds = recorded.at("seconds").get<double>();
        outcome.peak_memory_bytes = recorded.at("peak_memory_bytes").get<double>();
        outcome.run_started = recorded.at("run_started").get<std::string>();
    }
    return outcome;
}

}  // namespace

StepOutcome run_step(const JobStep& step, const StageContext& context) {
    context.reporter.info(step.name);
    std::vector<std::string> command = {(program_folder() / ("slim-" + step.verb)).string(),
                                        "--json"};
    command.insert(command.end(), context.passed_on.begin(), context.passed_on.end());
    command.insert(command.end(), step.arguments.begin(), step.arguments.end());
    hand_on_run_started();
    setenv(kErrorsByParent, "1", 1);  // said once, with the step's name
    const ChildResult child = run_child(command);
    unsetenv(kErrorsByParent);
    context.check_stop();
    if (child.exit_code != 0) fail(step, child);
    return outcome_of(step, child);
}

void require_inputs(const Job& job) {
    std::set<fs::path> made;
    for (const JobStep& step : job.steps) made.insert(step.output);
    for (const JobStep& step : job.steps)
        for (const fs::path& file : step.inputs) {
            std::error_code error;
            if (made.contains(file) || fs::exists(file, error)) continue;
            Fault fault{.problem =
                            fmt::format("{}: {}: no such file", step.name, file.string())};
            if (step.line > 0) fault.file = job.file.string(), fault.line = step.line;
            throw IoError(fault);
        }
}

json steps_json(const std::vector<StepOutcome>& outcomes) {
    json steps = json::array();
    for (const StepOutcome& outcome : outcomes)
        steps.push_back({{"name", outcome.step.name},
                         {"verb", outcome.step.verb},
                         {"up_to_date", outcome.up_to_date},
                         {"seconds", outcome.seconds},
                         {"peak_memory_bytes", outcome.peak_memory_bytes},
                         {"run_started", outcome.run_started},
                         {"result", outcome.result}});
    return steps;
}

std::string steps_summary(const std::vector<StepOutcome>& outcomes) {
    std::string text;
    for (const StepOutcome& outcome : outcomes)
        text += fmt::format("{:<16} {:>8.2f} s  {:>9}{}\n", outcome.step.name, outcome.seconds,
                            memory_size_text(static_cast<std::uint64_t>(outcome.peak_memory_bytes)),
                            outcome.up_to_date ? "  up to date (as recorded)" : "");
    for (const StepOutcome& outcome : outcomes)
        for (const json& command : outcome.result.value("film_commands", json::array()))
            text += "as a film: " + command.get<std::string>() + "\n";
    return text;
}

}  // namespace slim
