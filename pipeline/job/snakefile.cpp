#include "pipeline/job/snakefile.h"

#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/job/plan_steps.h"
#include "pipeline/manifest.h"
#include "pipeline/version.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = R"(# A Snakefile, made by 'slim plan JOB --format snakemake'.
#
# snakemake --cores 8 -s FILE does what 'slim run' does, the model slice by slice; a second time it does
# nothing. Slices whose normals are estimated take their signs from the slice before: in order. Paths are
# absolute. Print it anew after a change of the job: what has other options then runs again.
import json


def sliced():
    "The plan that slicing wrote."
    with open(checkpoints.slice.get().output.plan) as file:
        return json.load(file)


def slices():
    return range(len(sliced()["slices"]))

)";

/// A Python string.
std::string python_string(const std::string& text) {
    std::string out = "'";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\'' || c == '\\') out += '\\';
        if (byte < 0x20 || byte == 0x7f)
            out += fmt::format("\\x{:02x}", byte);
        else
            out += c;
    }
    return out + "'";
}

std::string python_list(const Words& words) {
    std::string out;
    for (const std::string& word : words) out += (out.empty() ? "" : ", ") + python_string(word);
    return "[" + out + "]";
}

/// A file of a rule: Snakemake takes braces in it for wildcards and knows no way to quote them.
std::string file_string(const fs::path& file) {
    if (file.string().find_first_of("{}") != std::string::npos)
        throw ConfigError(file.string() +
                          ": a name with braces, which Snakemake takes for wildcards; expected "
                          "others, such as another output.dir");
    return python_string(file.string());
}

std::string files_list(const std::vector<fs::path>& files) {
    std::string out;
    for (const fs::path& file : files) out += (out.empty() ? "" : ", ") + file_string(file);
    return out;
}

/// One rule; `input`, `output` and `command` are Python. `about` is what else it depends on: its
/// hash is one of the params.
struct Rule {
    std::string kind = "rule";
    std::string name, input, output, command, about = {};
};

class Rules {
public:
    explicit Rules(const ClusterResources& resources) : resources_(resources) {}

    void add(const Rule& rule) {
        text_ += fmt::format("\n{} {}:\n", rule.kind, rule.name);
        if (!rule.input.empty()) text_ += "    input: " + rule.input + "\n";
        // What a function returns is not filled in: braces of a command stay what they are.
        text_ += fmt::format(
            "    output: {}\n    params:\n        command=lambda w: {},\n        version={}\n",
            rule.output, rule.command, python_string(program_version()));
        if (!rule.about.empty())
            text_.insert(text_.size() - 1, fmt::format(",\n        about={}",
                                                       python_string(hash_text(rule.about))));
        text_ += fmt::format("    threads: {}\n    resources: mem_mb={}\n", resources_.threads,
                             (resources_.memory_bytes + (1 << 20) - 1) >> 20);
        text_ += "    shell: \"SLIM_THREADS={threads} {params.command:q}\"\n";
    }
    const std::string& text() const { return text_; }

private:
    ClusterResources resources_;
    std::string text_;
};

/// Manifest of a slice's file, its number replaced by what Python or Snakemake put there.
std::string of_slice(const fs::path& file, const std::string& number) {
    std::string text = file_string(manifest_path(file));
    const std::string folder = "/slice_0000/";
    text.replace(text.rfind(folder), folder.size(), "/slice_" + number + "/");
    return text;
}

/// The same for any slice i of Python's: a string to be formatted.
std::string formatted(const fs::path& file) { return "f" + of_slice(file, "{i:04}"); }

void add_slices(const Job& job, const fs::path& programs, Rules& rules) {
    const BuildStages& stages = job.stages;
    const std::string sliced = python_string(stages.slice_target.string());
    const fs::path normals = oriented_points_path(stages.work, 0), fits = fit_path(stages.work, 0);
    const auto command = [&](const char* verb, Words arguments) {
        return python_list(verb_command(programs, verb, arguments));
    };
    const std::string one = " + [f'--slice={int(w.slice)}']";
    const std::string in_order = stages.estimate_normals ? "True" : "not sliced()['has_normals']";
    rules.add({"rule", "normals",
               fmt::format("lambda w: [{}] + [{} for i in [int(w.slice) - 1] if i >= 0 and ({})]",
                           sliced, formatted(normals), in_order),
               of_slice(normals, "{slice,[0-9]+}"), command("normals", stages.normals) + one});
    Words coarse = stages.fit;
    coarse.push_back("--coarse");
    rules.add({"rule", "coarse",
               fmt::format("lambda w: [{} for i in slices()]", formatted(normals)),
               files_list({manifest_path(coarse_fit_path(stages.work))}), command("fit", coarse)});
    rules.add({"rule", "fit",
               fmt::format("lambda w: [{}] if len(slices()) > 1 else [{} for i in [0]]",
                           python_string(manifest_path(coarse_fit_path(stages.work)).string()),
                           formatted(normals)),
               of_slice(fits, "{slice,[0-9]+}"), command("fit", stages.fit) + one});
}

std::vector<fs::path> outputs_of(const PlanTask& task) {
    std::vector<fs::path> files = task.products;
    files.push_back(task.target);
    return files;
}

void add_task(const PlanTask& task, const std::string& name, Rules& rules) {
    rules.add({"rule", name, files_list(task.needs), files_list(outputs_of(task)),
               python_list(task.command)});
}

/// A step that is one task, or the tasks that share it and the one that joins them. A file is the
/// output of one rule: pictures of a film are those of their share. Returns all outputs.
std::vector<fs::path> add_step(const JobStep& step, const Job& job, const fs::path& programs,
                               const std::string& name, Rules& rules) {
    const PlanTask whole = whole_task(step, job, programs);
    if (step.shares.empty()) {
        add_task(whole, name, rules);
        return outputs_of(whole);
    }
    PlanTask join = join_task(step, job, programs);
    std::vector<fs::path> files;
    int number = 0;
    for (const PlanTask& share : share_tasks(step, job, programs)) {
        add_task(share, fmt::format("{}_share_{}", name, ++number), rules);
        for (const fs::path& file : outputs_of(share)) {
            files.push_back(file);
            std::erase(join.products, file);
        }
    }
    // As inputs too: where a share is drawn again, so that the whole is joined again.
    join.needs = files;
    add_task(join, name, rules);
    for (const fs::path& file : outputs_of(join)) files.push_back(file);
    return files;
}

void add_build(const JobStep& step, const Job& job, const fs::path& programs, Rules& rules) {
    const BuildStages& stages = job.stages;
    rules.add({"checkpoint", "slice", files_list(whole_task(step, job, programs).needs),
               "plan=" + files_list({plan_path(stages.work)}) +
                   ", done=" + files_list({stages.slice_target}),
               python_list(verb_command(programs, "slice", stages.slice))});
    add_slices(job, programs, rules);
    rules.add({"rule", "build",
               fmt::format("lambda w: [{} for i in slices()]", formatted(fit_path(stages.work, 0))),
               files_list(outputs_of(whole_task(step, job, programs))),
               python_list(joining_build(step, job, programs))});
}

}  // namespace

std::string snakefile_of(const Job& job, const fs::path& programs,
                         const ClusterResources& resources) {
    Rules rules(resources);
    std::vector<fs::path> goals;
    std::string about = job.title;
    int number = 0;
    for (const JobStep& step : job.steps) {
        about += fmt::format("\n{}", fmt::join(step.arguments, "\n"));
        if (step.verb == "build") {
            add_build(step, job, programs, rules);
            for (const fs::path& file : outputs_of(whole_task(step, job, programs)))
                goals.push_back(file);
            continue;
        }
        for (const fs::path& file :
             add_step(step, job, programs, fmt::format("{}_{}", step.verb, ++number), rules))
            goals.push_back(file);
    }
    if (job.html) {
        const fs::path page = job.folder / "index.html";
        rules.add({"rule", "page", files_list(goals), files_list({page, page_target(job)}),
                   python_list(verb_command(programs, "run", job_words(job))), about});
        goals.insert(goals.end(), {page, page_target(job)});
    }
    return kHeader + fmt::format("\nrule all:\n    input: {}\n", files_list(goals)) + rules.text();
}

}  // namespace slim
