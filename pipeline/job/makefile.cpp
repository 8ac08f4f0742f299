#include "pipeline/job/makefile.h"

#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/job/plan_steps.h"
#include "pipeline/manifest.h"
#include "pipeline/shell_word.h"
#include "pipeline/version.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = R"(# A Makefile for GNU make, made by 'slim plan {0} --format make'.
#
# make      does what 'slim run' does, the model slice by slice; a second time it does nothing, and
#           after a kill it goes on where it was.
# make -j2  works on slices, views and measures side by side (share the cores: SLIM_THREADS=1).
#           Slices whose normals are estimated take their signs from the slice before: in order.
#
# Paths are absolute: run it from any folder, with make -f FILE or make -C FOLDER. It remakes itself when
# the job file changes; print it anew when the job or the programs have moved. A step runs again when its
# options, its inputs or the program's version have changed, or when a file it makes is missing.
# The rules of the slices ({1})
# are known after slicing and included: even make -n slices the clouds first.
)";

/// A word of a recipe: quoted for the shell, its dollars for make.
std::string recipe_word(const std::string& text) {
    std::string out;
    for (const char c : shell_quoted(text)) out += c == '$' ? std::string("$$") : std::string(1, c);
    return out;
}

/// The same within a conditional, which counts parentheses.
std::string conditional_word(const std::string& text) {
    std::string out;
    for (const char c : recipe_word(text))
        out += c == '(' ? "$(open)" : c == ')' ? "$(close)" : std::string{c};
    return out;
}

/// Where make reads a name, each place with rules of its own for what it takes as syntax.
enum class Place { target, need, include, function };

std::string make_char(char c, Place place) {
    const auto is_one_of = [c](std::string_view set) {
        return set.find(c) != std::string_view::npos;
    };
    const bool in_rule = place == Place::target || place == Place::need;
    if (is_one_of("|;\n\\")) return "";
    if (c == '$') return "$$";
    if (c == '%') return place == Place::target ? "\\%" : "%";
    if (c == ':') return in_rule ? "\\:" : ":";
    if (is_one_of(" #*?[")) return std::string{'\\', c};
    if (in_rule && c == '=') return "$(equals)";
    if (place == Place::function && c == '(') return "$(open)";
    if (place == Place::function && c == ')') return "$(close)";
    if (place == Place::function && c == ',') return "$(comma)";
    return {c};
}

/// A path as a target, a prerequisite and so on; ConfigError where make has no way to write it.
std::string make_path(const fs::path& path, Place place) {
    std::string out;
    for (const char c : path.string()) {
        const std::string written = make_char(c, place);
        if (written.empty())
            throw ConfigError(
                fmt::format("{}: a Makefile cannot name a path with {}; expected another name, or "
                            "--format snakemake",
                            path.string(), c == '\n' ? "a line break" : std::string{c}));
        out += written;
    }
    return out;
}

/// A prerequisite that is out of date as long as the file is missing.
std::string unless_there(const fs::path& file) {
    return " $(if $(wildcard " + make_path(file, Place::function) + "),,FORCE)";
}

std::string text_of(const Words& words) { return fmt::format("{}", fmt::join(words, "\n")); }

class Rules {
public:
    Rules(const Job& job, const fs::path& programs)
        : marks_(job.folder / ".make"), programs_(programs) {}

    Words command(const std::string& verb, const Words& arguments) const {
        return verb_command(programs_, verb, arguments);
    }

    /// The rule that makes the stamp of these options; returns the stamp. `id` is the step's, alike
    /// for every slice of a stage.
    fs::path stamp(std::string id, const std::string& options) {
        std::replace(id.begin(), id.end(), '/', '_');
        const fs::path folder = marks_ / id;
        const fs::path file = folder / hash_text(program_version() + options).substr(0, 16);
        const std::string at = recipe_word(folder.string());
        text_ += fmt::format("\n{}:\n\t@rm -rf {} && mkdir -p {} && touch {}\n",
                             make_path(file, Place::target), at, at, recipe_word(file.string()));
        return file;
    }

    /// A step that has its stamp to itself.
    void step(const std::string& id, PlanTask rule) {
        rule.needs.push_back(stamp(id, text_of(rule.command)));
        add(rule);
    }

    /// A step that is up to date leaves its manifest as it was: touched, it is newer than its
    /// inputs.
    void add(const PlanTask& rule) {
        text_ += "\n" + make_path(rule.target, Place::target) + ":";
        for (const fs::path& need : rule.needs) text_ += " " + make_path(need, Place::need);
        for (const fs::path& product : rule.products) text_ += unless_there(product);
        text_ += "\n\t";
        for (const std::string& word : rule.command) text_ += recipe_word(word) + " ";
        text_.back() = '\n';
        text_ += "\t@touch " + recipe_word(rule.target.string()) + "\n";
    }

    void append(const std::string& text) { text_ += text; }
    const std::string& text() const { return text_; }
    fs::path slices_file() const { return marks_ / "slices.mk"; }

private:
    fs::path marks_, programs_;
    std::string text_;
};

/// Slicing, and the build that joins what the slices' rules have made: it finds them up to date.
void add_build(const JobStep& step, const Job& job, const fs::path& programs, Rules& rules) {
    PlanTask slice = whole_task(step, job, programs);
    slice.target = job.stages.slice_target;
    slice.products = {plan_path(job.stages.work)};
    slice.command = rules.command("slice", job.stages.slice);
    rules.step("slice", slice);
    PlanTask build = whole_task(step, job, programs);
    build.needs = {job.stages.slice_target};
    build.command = joining_build(step, job, programs);
    rules.step("build", build);
}

/// A step that is one task, or the tasks that share it, which have one stamp,
/// and the one that joins them.
void add_step(const JobStep& step, const Job& job, const fs::path& programs, Rules& rules) {
    if (step.shares.empty()) return rules.step(step.name, whole_task(step, job, programs));
    const fs::path mark = rules.stamp(step.name + " shares", text_of(step.arguments));
    for (PlanTask& share : share_tasks(step, job, programs)) {
        share.needs.push_back(mark);
        rules.add(share);
    }
    rules.step(step.name, join_task(step, job, programs));
}

/// Prints to a file only if that succeeds.
std::string printing_recipe(const fs::path& programs, const Job& job, const char* format,
                            const std::string& file) {
    std::string words = recipe_word((programs / "slim-plan").string());
    for (const std::string& word : job_words(job)) words += " " + recipe_word(word);
    return fmt::format("\t@{} --format={} > {}.tmp && mv {}.tmp {}\n", words, format, file, file,
                       file);
}

std::string slices_part(const Job& job, const Rules& rules, const fs::path& programs) {
    const fs::path file = rules.slices_file();
    const std::string job_file = make_path(job.file, Place::need);
    return fmt::format("\n{0}: {1} {2} $(wildcard $(this))\n", make_path(file, Place::target),
                       make_path(job.stages.slice_target, Place::need), job_file) +
           printing_recipe(programs, job, "slices", recipe_word(file.string())) +
           "\nifneq ($(wildcard $(this)),)\n$(this): " + job_file + "\n" +
           printing_recipe(programs, job, "make", "$(this)") +
           "else\n$(warning cannot tell its own file: print it anew after a change of the "
           "job)\nendif\n" +
           // A file that is to be remade first must not slice by what the job was before.
           "\nifeq ($(shell test " + conditional_word(job.file.string()) +
           " -nt '$(this)' && test -e '$(this)' && echo stale),)\ninclude " +
           make_path(file, Place::include) + "\nendif\n";
}

}  // namespace

std::string makefile_of(const Job& job, const fs::path& programs) {
    Rules rules(job, programs);
    std::vector<fs::path> goals;
    std::string all_commands = job.title;
    for (const JobStep& step : job.steps) {
        goals.push_back(step.target);
        all_commands += fmt::format("\n{}", fmt::join(step.arguments, "\n"));
        if (step.verb == "build")
            add_build(step, job, programs, rules);
        else
            add_step(step, job, programs, rules);
    }
    if (job.html) {
        PlanTask page{rules.command("run", job_words(job)),
                      goals,
                      page_target(job),
                      {job.folder / "index.html"}};
        page.needs.push_back(rules.stamp("page", all_commands));
        rules.add(page);
        goals = {page.target};
    }
    std::string text = fmt::format(kHeader, job.file.string(), rules.slices_file().string());
    text +=
        "\nthis := $(lastword $(MAKEFILE_LIST))\ncomma := ,\nopen := (\nclose := )\nequals := =\n\n"
        "all:";
    for (const fs::path& goal : goals) text += " " + make_path(goal, Place::need);
    return text + "\n.PHONY: all FORCE\nFORCE:\n" + rules.text() +
           slices_part(job, rules, programs);
}

std::string slice_rules_of(const Job& job, const SlicePlan& plan, const fs::path& programs) {
    const BuildStages& stages = job.stages;
    const bool in_order = normals_in_order(job, plan);
    Rules rules(job, programs);
    const auto add = [&](const char* verb, const Words& arguments, const std::string& part,
                         const fs::path& output, std::vector<fs::path> needs,
                         const fs::path& mark) {
        Words command = rules.command(verb, arguments);
        if (!part.empty()) command.push_back(part);
        needs.push_back(mark);
        rules.add({command, std::move(needs), manifest_path(output), {output}});
        return manifest_path(output);
    };
    rules.append("# The slices of " + job.file.string() + "\n");
    const fs::path normals_mark =
        rules.stamp("normals", text_of(stages.normals));
    const fs::path fit_mark = rules.stamp("fit", text_of(stages.fit));
    std::vector<fs::path> oriented, fits;
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        std::vector<fs::path> needs = {stages.slice_target};
        // Estimated normals take their signs from the slice before.
        if (in_order && i > 0) needs.push_back(oriented.back());
        oriented.push_back(add("normals", stages.normals, fmt::format("--slice={}", i),
                               oriented_points_path(stages.work, i), needs, normals_mark));
    }
    // lambda is a mean over all slices: the coarse levels wait for all normals, and every slice for
    // them.
    if (plan.slices.size() > 1)
        fits.push_back(
            add("fit", stages.fit, "--coarse", coarse_fit_path(stages.work), oriented, fit_mark));
    const std::vector<fs::path> before = fits.empty() ? oriented : fits;
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        fits.push_back(add("fit", stages.fit, fmt::format("--slice={}", i),
                           fit_path(stages.work, i), before, fit_mark));
    for (const JobStep& step : job.steps) {
        if (step.verb != "build") continue;
        rules.append("\n" + make_path(step.target, Place::target) + ":");
        for (const fs::path& fit : fits) rules.append(" " + make_path(fit, Place::need));
    }
    return rules.text() + "\n";
}

}  // namespace slim
