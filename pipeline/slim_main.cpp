// The front door: `slim fit ...` becomes `slim-fit ...` from the same folder.

#include "pipeline/child_process.h"
#include "pipeline/config.h"
#include "pipeline/json_text.h"
#include "pipeline/version.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

namespace {

struct Verb {
    const char* name;
    const char* summary;
};

constexpr Verb kVerbs[] = {
    {"scan", "virtual laser scanner over analytic shapes: a cloud with exact truth"},
    {"build", "clouds to model.slim in one go: slice, normals, fit, tree"},
    {"render", "pictures of a model: shaded, curvature maps, depth, normals, ..."},
    {"smooth", "points or a mesh moved onto a model's surface, attributes kept"},
    {"measure", "errors of a model against a cloud (and against its truth)"},
    {"info", "what is in a file: counts, bounds, attributes, provenance, health"},
    {"run", "all that a job file asks for, and a page with the results"},
    {"plan", "a job as a Makefile, a Slurm script or a Snakefile, or what it leaves out and why"},
    {"report", "experiments as curves of error against run time, jobs as rows, on one page"},
    {"slice", "stage 1: one or many clouds into slices with one origin"},
    {"normals", "stage 2: keep, estimate and orient normals"},
    {"fit", "stage 3: surfels of every level"},
    {"tree", "stage 4: surfels into model.slim"},
};

constexpr const char* kQuickStart = R"(
Quick start:
  slim build scan.ply -o scan.slim                      # a model of your own scan
  slim render scan.slim -o front.png                    # a shaded picture
  slim render scan.slim --aov mean -o curvature.png     # signed mean curvature
  slim measure scan.slim scan.ply                       # how well it fits
  slim smooth scan.slim scan.ply -o smooth.ply          # its points without their noise
  slim scan sculpture -o cloud.ply --noise 0.0005       # no scan at hand: make one

'slim VERB --help' (or 'slim help VERB') says more. Exit codes: 0 ok, 1 internal error, 2 usage, 3 bad input,
4 out of memory, disk or time, 5 numerical failure, 6 incomplete inputs, 75 busy,
130/143 interrupted.
)";

std::string help_text() {
    std::string text =
        "slim: raw 3D scans to surfel models and pictures\n\nUsage: slim VERB ...\n\n";
    for (const Verb& verb : kVerbs) text += fmt::format("  {:<8} {}\n", verb.name, verb.summary);
    return text + kQuickStart;
}

/// Says what went wrong; with --json on stdout too, as every verb does.
int fail(slim::ExitCode code, const std::string& message, bool as_json) {
    fmt::print(stderr, "slim: error: {}\n", message);
    if (as_json) {
        const nlohmann::json error = {
            {"error", {{"code", static_cast<int>(code)}, {"message", message}}}};
        fmt::print("{}\n", slim::text_of(error));
        std::fflush(stdout);
    }
    return static_cast<int>(code);
}

/// Prints an answer; a full disk or the like is an error.
int answer(const std::string& text, bool as_json) {
    errno = 0;
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    if (written && std::fflush(stdout) == 0) return 0;
    if (errno == EPIPE) return 128 + SIGPIPE;
    return fail(slim::ExitCode::resource,
                fmt::format("standard output: cannot write: {}", std::strerror(errno)), as_json);
}

int refuse(const std::string& verb, bool as_json) {
    std::vector<std::string> names;
    for (const Verb& known : kVerbs) names.push_back(known.name);
    return fail(slim::ExitCode::usage,
                fmt::format("unknown {} '{}'{}; 'slim --help' lists the verbs",
                            verb.starts_with('-') ? "option" : "verb", verb,
                            slim::suggestion(verb, names)),
                as_json);
}

bool is_verb(std::string_view word) {
    for (const Verb& verb : kVerbs)
        if (word == verb.name) return true;
    return false;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    const bool as_json = std::find(words.begin(), words.end(), "--json") != words.end();
    if (words.empty()) {
        std::fputs(help_text().c_str(), stderr);
        return static_cast<int>(slim::ExitCode::usage);
    }
    std::string verb = words[0];
    if (verb == "help" && words.size() > 1 && !words[1].starts_with('-')) {
        verb = words[1];
        words = {verb, "--help"};
    }
    if (verb == "--help" || verb == "-h" || verb == "help") return answer(help_text(), as_json);
    if (verb == "--version")
        return answer(fmt::format("slim {}\n", slim::program_version()), as_json);
    if (verb == "--json")
        return fail(slim::ExitCode::usage, "no verb before --json; 'slim --help' lists the verbs",
                    true);
    if (!is_verb(verb)) return refuse(verb, as_json);
    words[0] = (slim::program_folder() / ("slim-" + verb)).string();
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execv(arguments[0], arguments.data());
    return fail(slim::ExitCode::internal,
                fmt::format("{}: cannot run: {}", words[0], std::strerror(errno)), as_json);
}
