#include "pipeline/report_steps.h"

#include "formats/atomic_file.h"
#include "pipeline/child_process.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/median.h"
#include "pipeline/report_cloud.h"
#include "pipeline/report_record.h"
#include "pipeline/report_text.h"
#include "pipeline/report_times.h"
#include "pipeline/version.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <unistd.h>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kOut = "<out>";  // stands for the output until its name, a hash, is known

bool is_verb(const std::string& run) { return run != "cloud" && run != "text" && run != "command"; }

/// Words between spaces; those within {} do not part.
std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words(1);
    int depth = 0;
    for (const char c : text) {
        depth += c == '{' ? 1 : c == '}' ? -1 : 0;
        const bool parts = depth == 0 && (c == ' ' || c == '\t' || c == '\n');
        if (!parts)
            words.back() += c;
        else if (!words.back().empty())
            words.emplace_back();
    }
    if (words.back().empty()) words.pop_back();
    return words;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
        text.replace(at, what.size(), by);
    return text;
}

/// The file that a word may name: "scan.ply", "--truth=scan.truth".
std::string file_of(const std::string& word) {
    const std::size_t sign = word.starts_with("-") ? word.find('=') : std::string::npos;
    return sign == std::string::npos ? word : word.substr(sign + 1);
}

/// The JSON object that a program wrote: all of its output, or the last line that is one;
/// empty without.
json object_in(const std::string& output) {
    json whole = json_or_discarded(output);
    if (whole.is_object()) return whole;
    std::istringstream in(output);
    json found = json::object();
    for (std::string line; std::getline(in, line);) {
        json object = json_or_discarded(line);
        if (object.is_object()) found = std::move(object);
    }
    return found;
}

/// Warnings counted, and the first of them, from what a child wrote on stderr.
void put_warnings(const std::string& log, json& figures) {
    std::ifstream in(log);
    std::uint64_t n = 0;
    std::string first;
    for (std::string line; std::getline(in, line);) {
        const std::size_t at = line.find("warning: ");
        if (at == std::string::npos) continue;
        if (n++ == 0) first = line.substr(at + 9);
    }
    figures["warnings"] = n;
    figures["warning"] = first;
}

struct Times {
    std::vector<double> seconds, processor;
    void put(json& figures) const {
        figures["seconds"] = median(seconds);
        figures["seconds_min"] = *std::min_element(seconds.begin(), seconds.end());
        figures["seconds_max"] = *std::max_element(seconds.begin(), seconds.end());
        figures["processor_seconds"] = median(processor);
        figures["runs"] = seconds.size();
    }
};

}  // namespace

/// What is known of a step before it is run.
struct StepRunner::Planned {
    std::string name, output, program;
    std::vector<std::string> words, from;
    std::uint64_t points = 0;
    std::string missing;  ///< why it cannot be run: no program, or an input that is not there
};

StepRunner::StepRunner(StepSettings settings, StageContext& context)
    : settings_(std::move(settings)), context_(context), started_(run_stamp()) {}

std::string StepRunner::program_path(const std::string& name) const {
    std::vector<std::string> folders = {program_folder().string()};
    folders.insert(folders.end(), settings_.programs.begin(), settings_.programs.end());
    std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
    for (std::string folder; std::getline(path, folder, ':');) folders.push_back(folder);
    for (const std::string& folder : folders) {
        const fs::path program = fs::path(folder) / name;
        std::error_code error;
        if (fs::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0)
            return program.string();
    }
    return "";
}

std::string StepRunner::hash_of(const std::string& file) {
    const auto found = hashes_.find(file);
    return found != hashes_.end() ? found->second : hashes_[file] = hash_file(file);
}

StepRunner::Planned StepRunner::plan(const ReportStep& step, const ReportRow& row) {
    Planned out;
    const Expression::Lookup lookup = [&](const std::string& name) -> FigureValue {
        return name == "out" ? FigureValue(std::string(kOut)) : row.at(name);
    };
    std::string key = fmt::format("{} {} {} {} {}", program_version(), step.run, context_.threads,
                                  step.repeat, step.out);
    try {
        for (const std::string& word : words_of(step.args))
            out.words.push_back(filled(word, lookup, 17, step.where));
        for (const std::string& word : step.from)
            out.from.push_back(filled(word, lookup, 17, step.where));
        if (!step.points.empty())
            out.points = static_cast<std::uint64_t>(
                std::max(0.0, Expression(filled(step.points, lookup, 17, step.where), step.where)
                                  .number(lookup)));
        if (step.run == "cloud")
            key += fmt::format(" seed {} points {} {}", settings_.seed, out.points, step.single);
        for (const auto& [target, formula] : step.point) {
            key += fmt::format(" {}={}", target, formula.text());
            for (const std::string& name : formula.names())
                if (const auto value = row.value(Expression(name, step.where)))
                    key += fmt::format(" {}:{}{}", name, value->text, value->number);
        }
        key += filled(step.text, lookup, 17, step.where);
    } catch (const MissingFigure& missing) {
        out.missing = "needs '" + missing.name + "'";
        return out;
    }
    if (step.run == "command") {
        out.program = program_path(step.program);
        if (out.program.empty()) {
            out.missing = step.program + " is not installed";
            return out;
        }
    } else {
        const bool ours = step.run == "cloud" || step.run == "text";
        out.program = (program_folder() / (ours ? "slim-report" : "slim-" + step.run)).string();
    }
    // The version says nothing of a program that was changed and built again.
    std::error_code none;
    if (fs::is_regular_file(out.program, none)) key += " " + hash_of(out.program);
    const std::string ours = settings_.folder.string() + "/";
    for (const auto* words : {&out.words, &out.from})
        for (const std::string& word : *words) {
            key += " " + replaced(word, ours, "");
            const std::string file = file_of(word);
            std::error_code error;
            if (!file.starts_with(ours) && fs::is_regular_file(file, error)) key += hash_of(file);
        }
    out.name = step.name + "-" + hash_text(key).substr(0, 12);
    if (!step.out.empty()) out.output = ours + out.name + step.out;
    for (std::string& word : out.words) word = replaced(word, kOut, out.output);
    return out;
}

StepRecord StepRunner::run_program(const ReportStep& step, const Planned& planned) {
    StepRecord record;
    std::vector<std::string> command;
    if (is_verb(step.run)) {
        command = {planned.program, "--json", "--quiet", "--force",
                   fmt::format("--threads={}", context_.threads)};
    } else {
        command = {planned.program};
    }
    command.insert(command.end(), planned.words.begin(), planned.words.end());
    if (is_verb(step.run) && !planned.output.empty())
        command.insert(command.end(), {"-o", planned.output});
    const std::string log = (settings_.folder / (planned.name + ".log")).string();
    Times times;
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
StepRecord StepRunner::made(const ReportStep& step, const ReportRow& row, const Planned& planned) {
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
                                const Planned& planned) {
    const bool ours = step.run == "cloud" || step.run == "text";
    StepRecord record = ours ? made(step, row, planned) : run_program(step, planned);
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
                             const Planned& planned) {
    for (const auto* words : {&planned.words, &planned.from})
        for (const std::string& word : *words)
            for (std::size_t i = 0; i < row.steps.size(); ++i) {
                if (word != row.steps[i].output || fs::exists(word)) continue;
                const auto step = std::find_if(
                    experiment.steps.begin(), experiment.steps.end(),
                    [&](const ReportStep& s) { return s.name == row.steps[i].step; });
                const Planned again = plan(*step, row);
                make_inputs(experiment, row, again);
                executed(*step, row, again);
            }
}

StepRecord StepRunner::done(const Experiment& experiment, const ReportStep& step,
                            const ReportRow& row) {
    const Planned planned = plan(step, row);
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
