#include "pipeline/job.h"
#include "pipeline/manifest.h"

#include <fmt/format.h>

#include <string>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// A word of a recipe: quoted for the shell, its dollars for make.
std::string recipe_word(const std::string& text) {
    std::string out = "'";
    for (const char c : text) {
        if (c == '\'')
            out += "'\\''";
        else if (c == '$')
            out += "$$";
        else
            out += c;
    }
    return out + "'";
}

/// A path as target or prerequisite.
std::string make_path(const fs::path& path) {
    std::string out;
    for (const char c : path.string()) {
        if (c == ' ' || c == '#' || c == ':' || c == '%') out += '\\';
        out += c;
        if (c == '$') out += '$';
    }
    return out;
}

/// What a step leaves when it is done; a step that only answers leaves a file of its answer.
fs::path target_of(const JobStep& step, const Job& job) {
    if (!step.output.empty()) return manifest_path(step.output);
    std::string name = step.name;
    for (char& c : name)
        if (c == ' ' || c == '/') c = '_';
    return job.folder / (name + ".json");
}

/// The target that makes a file, or the file itself if no step does.
fs::path made_by(const fs::path& file, const Job& job) {
    for (const JobStep& step : job.steps)
        if (step.output == file) return target_of(step, job);
    return file;
}

std::string rule_of(const JobStep& step, const Job& job, const fs::path& programs) {
    const fs::path target = target_of(step, job);
    std::string rule = make_path(target) + ":";
    for (const fs::path& input : step.inputs) rule += " " + make_path(made_by(input, job));
    rule += " | " + make_path(job.folder) + "\n\t" +
            recipe_word((programs / ("slim-" + step.verb)).string());
    for (const std::string& argument : step.arguments) rule += " " + recipe_word(argument);
    const std::string file = recipe_word(target.string());
    if (step.output.empty())
        return rule + fmt::format(" --json > {0}.tmp && mv {0}.tmp {0}\n", file);
    return rule + "\n\t@touch " + file + "\n";
}

}  // namespace

std::string makefile_of(const Job& job, const fs::path& program_folder) {
    std::string text = fmt::format("# Made by 'slim plan {} --format make'.\n\nall:", job.file.string());
    for (const JobStep& step : job.steps) text += " " + make_path(target_of(step, job));
    text += "\n.PHONY: all\n.DELETE_ON_ERROR:\n\n" + make_path(job.folder) + ":\n\tmkdir -p " +
            recipe_word(job.folder.string()) + "\n";
    for (const JobStep& step : job.steps) text += "\n" + rule_of(step, job, program_folder);
    return text;
}

std::string explanation_of(const Job& job) {
    std::string text = "Done, in this order:\n";
    for (const JobStep& step : job.steps)
        text += fmt::format("  {}: slim {} {}\n", step.name, step.verb, fmt::join(step.arguments, " "));
    if (job.html)
        text += fmt::format("  page: {}\n", (job.folder / "index.html").string());
    text += "Left out:\n";
    for (const std::string& reason : job.left_out) text += "  " + reason + "\n";
    return text;
}

}  // namespace slim
