#include "pipeline/report/report_step_plan.h"

#include "pipeline/child_process.h"
#include "pipeline/manifest.h"
#include "pipeline/report/report_text.h"
#include "pipeline/version.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include <unistd.h>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOut = "<out>";  // stands for the output until its name, a hash, is known

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

/// The file that a word may name: "scan.ply", "--truth=scan.truth".
std::string file_of(const std::string& word) {
    const std::size_t sign = word.starts_with("-") ? word.find('=') : std::string::npos;
    return sign == std::string::npos ? word : word.substr(sign + 1);
}

}  // namespace

bool is_made_here(const ReportStep& step) { return step.run == "cloud" || step.run == "text"; }

std::string StepPlanner::program_path(const std::string& name) const {
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

std::string StepPlanner::hash_of(const std::string& file) {
    const auto found = hashes_.find(file);
    return found != hashes_.end() ? found->second : hashes_[file] = hash_file(file);
}

/// Fills words and points; returns what they and the step's own settings put into the hash.
/// throws MissingFigure for a name that has no value in this row
std::string StepPlanner::fill(const ReportStep& step, const ReportRow& row,
                              PlannedStep& out) const {
    const Expression::Lookup lookup = [&](const std::string& name) -> FigureValue {
        return name == "out" ? FigureValue(std::string(kOut)) : row.at(name);
    };
    const auto exactly = [&](const std::string& text) {
        return filled(text, lookup, 17, step.where);
    };
    std::string key = fmt::format("{} {} {} {} {}", program_version(), step.run, threads_,
                                  step.repeat, step.out);
    for (const std::string& word : words_of(step.args)) out.words.push_back(exactly(word));
    for (const std::string& word : step.from) out.from.push_back(exactly(word));
    if (!step.points.empty())
        out.points = static_cast<std::uint64_t>(
            std::max(0.0, Expression(exactly(step.points), step.where).number(lookup)));
    if (step.run == "cloud")
        key += fmt::format(" seed {} points {} {}", settings_.seed, out.points, step.single);
    for (const auto& [target, formula] : step.point) {
        key += fmt::format(" {}={}", target, formula.text());
        for (const std::string& name : formula.names())
            if (const auto value = row.value(Expression(name, step.where)))
                key += fmt::format(" {}:{}{}", name, value->text, value->number);
    }
    return key + exactly(step.text);
}

void StepPlanner::find_program(const ReportStep& step, PlannedStep& out) const {
    if (step.run == "command") {
        out.program = program_path(step.program);
        if (out.program.empty()) out.missing = step.program + " is not installed";
    } else {
        const std::string verb = is_made_here(step) ? "report" : step.run;
        out.program = (program_folder() / ("slim-" + verb)).string();
    }
}

/// What the program and the words put into the hash, with the bytes of files outside the folder.
std::string StepPlanner::key_of_files(const PlannedStep& planned) {
    std::string key;
    // The version says nothing of a program that was changed and built again.
    std::error_code none;
    if (fs::is_regular_file(planned.program, none)) key += " " + hash_of(planned.program);
    const std::string ours = settings_.folder.string() + "/";
    for (const auto* words : {&planned.words, &planned.from})
        for (const std::string& word : *words) {
            key += " " + replaced(word, ours, "");
            const std::string file = file_of(word);
            std::error_code error;
            if (!file.starts_with(ours) && fs::is_regular_file(file, error)) key += hash_of(file);
        }
    return key;
}

PlannedStep StepPlanner::plan(const ReportStep& step, const ReportRow& row) {
    PlannedStep out;
    std::string key;
    try {
        key = fill(step, row, out);
    } catch (const MissingFigure& missing) {
        out.missing = "needs '" + missing.name + "'";
        return out;
    }
    find_program(step, out);
    if (!out.missing.empty()) return out;
    key += key_of_files(out);
    out.name = step.name + "-" + hash_text(key).substr(0, 12);
    if (!step.out.empty()) out.output = settings_.folder.string() + "/" + out.name + step.out;
    for (std::string& word : out.words) word = replaced(word, kOut, out.output);
    return out;
}

}  // namespace slim
