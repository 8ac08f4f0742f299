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

/// The target that makes a file, or the file itself if no step does.
fs::path made_by(const fs::path& file, const Job& job) {
    for (const JobStep& step : job.steps)
        if (step.output == file) return step.target;
    return file;
}

std::string rule_of(const JobStep& step, const Job& job, const fs::path& programs) {
    std::string rule = make_path(step.target) + ":";
    for (const fs::path& input : step.inputs) rule += " " + make_path(made_by(input, job));
    rule += " | " + make_path(job.folder) + "\n\t" +
            recipe_word((programs / ("slim-" + step.verb)).string());
    for (const std::string& argument : step.arguments) rule += " " + recipe_word(argument);
    const std::string file = recipe_word(step.target.string());
    if (step.output.empty())
        return rule + fmt::format(" --json > {0}.tmp && mv {0}.tmp {0}\n", file);
    return rule + "\n\t@touch " + file + "\n";
}

}  // namespace

std::string makefile_of(const Job& job, const fs::path& program_folder) {
    std::string goals, rules;
    for (const JobStep& step : job.steps) {
        goals += " " + make_path(step.target);
        if (step.verb != "build") rules += "\n" + rule_of(step, job, program_folder);
    }
    for (const JobStep& step : job.build_stages) rules += "\n" + rule_of(step, job, program_folder);
    const std::string folder = make_path(job.folder);
    return fmt::format("# Made by 'slim plan {} --format make'.\n\nall:{}\n.PHONY: all\n"
                       ".DELETE_ON_ERROR:\n\n{}:\n\tmkdir -p {}\n{}",
                       job.file.string(), goals, folder, recipe_word(job.folder.string()), rules);
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
