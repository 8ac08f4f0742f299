#include "pipeline/build/edges_said.h"
#include "pipeline/job/job.h"
#include "pipeline/json_text.h"
#include "pipeline/shell_word.h"

#include <fmt/format.h>

#include <fstream>
#include <string>
#include <vector>

namespace slim {

namespace {

/// What plans make of a view that is large; nothing of the others.
std::string division_text(const JobStep& step) {
    if (step.division.empty()) return "";
    return fmt::format("    in plans {}: {}\n",
                       step.shares.empty()
                           ? "one task"
                           : fmt::format("{} tasks and one that joins", step.shares.size()),
                       step.division);
}

/// What the points said of their edges when the model was last built; empty where they were not
/// asked, or never yet.
std::string last_said_text(const Job& job) {
    std::string text;
    for (const JobStep& step : job.steps) {
        if (step.verb != "build" || job.stages.sharp != "auto") continue;
        std::ifstream in(step.target);
        const auto manifest = json_or_discarded(in);
        if (manifest.is_object() && manifest.contains("result"))
            text = edges_text(manifest.at("result"), Remedies::of_a_job);
    }
    return text.empty() ? "" : "As the model was last built: " + text + "\n";
}

/// Reasons below their heading; nothing without any.
std::string list_of(const char* heading, const std::vector<std::string>& reasons) {
    if (reasons.empty()) return "";
    std::string text = heading;
    for (const std::string& reason : reasons) text += "  " + reason + "\n";
    return text;
}

}  // namespace

std::string explanation_of(const Job& job) {
    std::vector<std::string> refused;
    for (const ConfigError& error : job.refused) refused.emplace_back(error.what());
    std::string text = list_of("`slim run` refuses this job:\n", refused);
    text += refused.empty() ? "`slim run` does, in this order:\n"
                            : "Without that it would do, in this order:\n";
    for (const JobStep& step : job.steps)
        text +=
            fmt::format("  {}: slim {} {}\n", step.name, step.verb, shell_line(step.arguments)) +
            division_text(step);
    if (job.html)
        text += fmt::format("  page: {}\n", (job.folder / "index.html").string());
    text += "Left out:\n";
    for (const std::string& reason : job.left_out) text += "  " + reason + "\n";
    text += last_said_text(job);
    text += list_of("Asked for, but will be missing:\n", job.missing);
    text += list_of("Asked for, but may be missing, as the points decide:\n", job.uncertain);
    return text;
}

}  // namespace slim
