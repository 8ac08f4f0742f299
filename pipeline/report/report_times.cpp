#include "pipeline/report/report_times.h"

#include <algorithm>

namespace slim {
namespace {

constexpr const char* kUnknown = "(unknown)";  // of records without: sorts before every date

const std::string& run_of(const StepRecord& step) {
    static const std::string unknown = kUnknown;
    return step.run_started.empty() ? unknown : step.run_started;
}

bool names_time(const Expression& formula) {
    return std::any_of(formula.names().begin(), formula.names().end(), [](const std::string& name) {
        const std::size_t dot = name.find('.');
        return dot != std::string::npos && is_time(name.substr(dot + 1));
    });
}

}  // namespace

bool is_time(const std::string& figure) {
    return figure.find("seconds") != std::string::npos || figure.find("_ms") != std::string::npos;
}

std::set<std::string> runs_timed(const Expression& formula, const ReportRow& row) {
    std::set<std::string> runs;
    for (const std::string& name : formula.names()) {
        const std::size_t dot = name.find('.');
        if (dot == std::string::npos || !is_time(name.substr(dot + 1))) continue;
        const StepRecord* step = row.step(name.substr(0, dot));
        if (step && !step->absent) runs.insert(run_of(*step));
    }
    return runs;
}

std::set<std::string> runs_timed(const Experiment& experiment, const ReportRow& row) {
    std::set<std::string> runs;
    for (const auto& [heading, formula] : experiment.columns) runs.merge(runs_timed(formula, row));
    return runs;
}

bool has_times(const Experiment& experiment) {
    return std::any_of(experiment.columns.begin(), experiment.columns.end(),
                       [](const auto& column) { return names_time(column.second); });
}

std::map<std::string, std::size_t> steps_by_run(const Report& report) {
    std::map<std::string, std::set<std::string>> names;
    for (const auto& of_file : report.results)
        for (const ExperimentResult& result : of_file)
            for (const ReportRow& row : result.rows)
                for (const StepRecord& step : row.steps)
                    if (!step.name.empty()) names[run_of(step)].insert(step.name);
    std::map<std::string, std::size_t> out;
    for (const auto& [run, steps] : names) out[run] = steps.size();
    return out;
}

}  // namespace slim
