#include "pipeline/job/job.h"
#include "pipeline/shell_word.h"

#include <fmt/format.h>

#include <string>

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

}  // namespace

std::string explanation_of(const Job& job) {
    std::string text = "`slim run` does, in this order:\n";
    for (const JobStep& step : job.steps)
        text +=
            fmt::format("  {}: slim {} {}\n", step.name, step.verb, shell_line(step.arguments)) +
            division_text(step);
    if (job.html)
        text += fmt::format("  page: {}\n", (job.folder / "index.html").string());
    text += "Left out:\n";
    for (const std::string& reason : job.left_out) text += "  " + reason + "\n";
    if (!job.missing.empty()) text += "Asked for, but will be missing:\n";
    for (const std::string& reason : job.missing) text += "  " + reason + "\n";
    return text;
}

}  // namespace slim
