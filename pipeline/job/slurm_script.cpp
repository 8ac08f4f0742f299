#include "pipeline/job/slurm_script.h"

#include "pipeline/job/plan_steps.h"
#include "pipeline/shell_word.h"

#include <fmt/format.h>

#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = R"(#!/bin/sh
# Submits what 'slim run' does to Slurm, made by 'slim plan JOB --format slurm'.
#
# sh FILE [OPTIONS OF sbatch]   such as --partition=short --time=2:00:00 --mem=16G; they go to every job and
#                               win over what stands here. Words are parted at blanks.
#
# The job of the slicing submits the rest, for only then the slices are known: sbatch must be allowed within
# jobs. A job whose predecessor failed is cancelled. What is up to date says so and ends: after a failure run
# the script again. Logs lie in the folder .slurm of the job's own folder. Paths are absolute.
set -euf
)";

constexpr const char* kSubmit = R"(
# submit NAME [OPTIONS OF sbatch] < SCRIPT: the job's number in $id
submit() {{
    name=$1
    shift
    case " ${{SLIM_SBATCH-}} " in   # sbatch takes one way to ask for memory
    *" --mem="*|*" --mem "*|*" --mem-per-"*) memory= ;;
    *) memory=--mem={}M ;;
    esac
    id=$(sbatch --parsable --export=ALL --job-name="slim-$name" --output={} \
         --cpus-per-task={} $memory --signal=B:TERM@60 --kill-on-invalid-dep=yes "$@" ${{SLIM_SBATCH-}})
    id=${{id%%;*}}
    echo "$name: job $id"
}}
)";

fs::path logs_of(const Job& job) { return job.folder / ".slurm"; }

/// A folder in a file name pattern of sbatch, in which % begins a field.
std::string log_pattern(const fs::path& logs) {
    std::string out;
    for (const char c : logs.string()) out += c == '%' ? std::string("%%") : std::string(1, c);
    return shell_quoted(out) + "/\"$name\"-%j.log";
}

std::string quoted_line(const Words& words) {
    std::string line;
    for (const std::string& word : words) line += (line.empty() ? "" : " ") + shell_quoted(word);
    return line;
}

std::string submit_function(const Job& job, const ClusterResources& resources) {
    const std::uint64_t mib = (resources.memory_bytes + (1 << 20) - 1) >> 20;
    return fmt::format(kSubmit, mib, log_pattern(logs_of(job)), resources.threads);
}

/// One job: `options` of sbatch, unquoted; `script` its commands.
std::string submission(const std::string& name, const std::string& options,
                       const std::string& script) {
    return fmt::format("\nsubmit {} {}<<'END_OF_JOB'\n#!/bin/sh\nset -eu\n{}\nEND_OF_JOB\n",
                       shell_word(name), options.empty() ? "" : options + " ", script);
}

std::string after(const std::string& ids) { return "--dependency=afterok:" + ids; }

/// An array job: task k runs command k.
std::string array_submission(const std::string& name, const std::string& options,
                             const std::vector<Words>& commands) {
    if (commands.size() == 1) return submission(name, options, "exec " + quoted_line(commands[0]));
    std::string script = "case $SLURM_ARRAY_TASK_ID in\n";
    for (std::size_t k = 0; k < commands.size(); ++k)
        script += fmt::format("{}) exec {} ;;\n", k, quoted_line(commands[k]));
    script += "esac";
    return submission(name, fmt::format("--array=0-{} {}", commands.size() - 1, options), script);
}

/// An array job over slices: each takes its number from the array. One slice a task: there are at
/// most 500, within Slurm's usual MaxArraySize of 1001.
std::string slices_submission(const std::string& name, const std::string& options,
                              const Words& command, std::size_t n) {
    return submission(name,
                      fmt::format("--array=0-{}{}{}", n - 1, options.empty() ? "" : " ", options),
                      "exec " + quoted_line(command) + " --slice=\"$SLURM_ARRAY_TASK_ID\"");
}

/// All of a verb, those that share a step among them.
std::vector<Words> commands_of(const Job& job, const std::string& verb, const fs::path& programs) {
    std::vector<Words> commands;
    for (const JobStep& step : job.steps) {
        if (step.verb != verb) continue;
        for (const PlanTask& share : share_tasks(step, job, programs))
            commands.push_back(share.command);
        if (step.shares.empty()) commands.push_back(whole_task(step, job, programs).command);
    }
    return commands;
}

std::vector<Words> joining_commands(const Job& job, const fs::path& programs) {
    std::vector<Words> commands;
    for (const JobStep& step : job.steps)
        if (!step.shares.empty()) commands.push_back(join_task(step, job, programs).command);
    return commands;
}

/// Normals, coarse levels and fits; the last one's number in $id.
std::string slices_text(const Job& job, const SlicePlan& plan, const fs::path& programs) {
    const BuildStages& stages = job.stages;
    const std::size_t n = plan.slices.size();
    const Words normals = verb_command(programs, "normals", stages.normals);
    Words fit = verb_command(programs, "fit", stages.fit);
    // One job takes the slices in order.
    std::string text = normals_in_order(job, plan)
                           ? submission("normals", "", "exec " + quoted_line(normals))
                           : slices_submission("normals", "", normals, n);
    if (n > 1) {
        Words coarse = fit;
        coarse.push_back("--coarse");
        text += submission("coarse", after("$id"), "exec " + quoted_line(coarse));
    }
    return text + slices_submission("fit", after("$id"), fit, n);
}

}  // namespace

std::string slurm_script_of(const Job& job, const fs::path& programs,
                            const ClusterResources& resources) {
    const std::string second = shell_quoted((logs_of(job) / "slices.sh").string());
    std::string text = kHeader;
    text += fmt::format("export SLIM_SBATCH=\"$*\"\nmkdir -p {}\n",
                        shell_quoted(logs_of(job).string()));
    text += submit_function(job, resources);
    std::string options;
    for (const JobStep& step : job.steps) {
        if (step.verb != "scan") continue;
        text += submission("scan", "",
                           "exec " + quoted_line(verb_command(programs, "scan", step.arguments)));
        options = after("$id");
    }
    Words print = verb_command(programs, "plan", job_words(job));
    print.insert(print.end(),
                 {"--format=slurm-slices", fmt::format("--threads={}", resources.threads),
                  fmt::format("--memory={}", resources.memory_bytes)});
    return text +
           submission("slice", options,
                      fmt::format("{}\n{} > {}\nexec sh {}",
                                  quoted_line(verb_command(programs, "slice", job.stages.slice)),
                                  quoted_line(print), second, second));
}

std::string slurm_slices_of(const Job& job, const SlicePlan& plan, const fs::path& programs,
                            const ClusterResources& resources) {
    std::string text = "#!/bin/sh\n# The slices of " + job.file.string() +
                       " and what follows\nset -euf\n" + submit_function(job, resources) +
                       slices_text(job, plan, programs);
    for (const JobStep& step : job.steps)
        if (step.verb == "build")
            text += submission("build", after("$id"),
                               "exec " + quoted_line(joining_build(step, job, programs)));
    text += "all=$id\nbuild=$id\n";
    for (const char* verb : {"measure", "render"})
        if (const auto commands = commands_of(job, verb, programs); !commands.empty())
            text += array_submission(verb, after("$build"), commands) + "all=$all:$id\n";
    // of the views, submitted last
    if (const auto commands = joining_commands(job, programs); !commands.empty())
        text += array_submission("join", after("$id"), commands) + "all=$all:$id\n";
    if (job.html)
        text += submission("page", after("$all"),
                           "exec " + quoted_line(verb_command(programs, "run", job_words(job))));
    return text;
}

}  // namespace slim
