// The front door: `slim fit ...` becomes `slim-fit ...` from the same folder.

#include "pipeline/child_process.h"
#include "pipeline/config.h"
#include "pipeline/version.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cerrno>
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
    {"report", "experiments as curves of error against run time, on one page"},
    {"slice", "stage 1: one or many clouds into slices with one origin"},
    {"normals", "stage 2: keep, estimate and orient normals"},
    {"fit", "stage 3: surfels of every level"},
    {"tree", "stage 4: surfels into model.slim"},
};

void print_help() {
    fmt::print("slim: raw 3D scans to surfel models and pictures\n\nUsage: slim VERB ...\n\n");
    for (const Verb& verb : kVerbs) fmt::print("  {:<8} {}\n", verb.name, verb.summary);
    fmt::print(R"(
Quick start:
  slim build scan.ply -o scan.slim                      # a model of your own scan
  slim render scan.slim -o front.png                    # a shaded picture
  slim render scan.slim --aov mean -o curvature.png     # signed mean curvature
  slim measure scan.slim scan.ply                       # how well it fits
  slim smooth scan.slim scan.ply -o smooth.ply          # its points without their noise
  slim scan sculpture -o cloud.ply --noise 0.0005       # no scan at hand: make one

'slim VERB --help' says more. Exit codes: 0 ok, 1 internal error, 2 usage, 3 bad input,
4 out of memory, disk or time, 5 numerical failure, 6 incomplete inputs, 75 busy,
130/143 interrupted.
)");
}

int fail(int code, const std::string& message) {
    fmt::print(stderr, "slim: error: {}\n", message);
    return code;
}

int refuse(const std::string& verb) {
    std::vector<std::string> names;
    for (const Verb& known : kVerbs) names.push_back(known.name);
    return fail(static_cast<int>(slim::ExitCode::usage),
                fmt::format("unknown verb '{}'{}; 'slim --help' lists them", verb,
                            slim::suggestion(verb, names)));
}

bool is_verb(std::string_view word) {
    for (const Verb& verb : kVerbs)
        if (word == verb.name) return true;
    return false;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string verb = argc > 1 ? argv[1] : "--help";
    if (verb == "--help" || verb == "-h" || verb == "help") {
        print_help();
        return std::fflush(stdout) == 0 && argc > 1 ? 0 : static_cast<int>(slim::ExitCode::usage);
    }
    if (verb == "--version") {
        fmt::print("slim {}\n", slim::program_version());
        return 0;
    }
    if (!is_verb(verb)) return refuse(verb);
    const std::string program = (slim::program_folder() / ("slim-" + verb)).string();
    argv[1] = const_cast<char*>(program.c_str());
    execv(program.c_str(), argv + 1);
    return fail(static_cast<int>(slim::ExitCode::internal),
                fmt::format("{}: cannot run: {}", program, std::strerror(errno)));
}
