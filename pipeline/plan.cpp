#include "pipeline/job.h"
#include "pipeline/shell_word.h"

#include <fmt/format.h>

#include <string>

namespace slim {

std::string explanation_of(const Job& job) {
    std::string text = "`slim run` does, in this order:\n";
    for (const JobStep& step : job.steps)
        text += fmt::format("  {}: slim {} {}\n", step.name, step.verb, shell_line(step.arguments));
    if (job.html)
        text += fmt::format("  page: {}\n", (job.folder / "index.html").string());
    text += "Left out:\n";
    for (const std::string& reason : job.left_out) text += "  " + reason + "\n";
    return text;
}

}  // namespace slim
