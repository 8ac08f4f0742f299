#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// One command of a job: slim-<verb> with its arguments.
struct JobStep {
    std::string name;  ///< "scan", "build", "measure cloud.ply", "view front"
    std::string verb;
    std::vector<std::string> arguments;
    std::vector<std::filesystem::path> inputs;  ///< files it reads (outputs of earlier steps among them)
    std::filesystem::path output;               ///< what -o names; empty if it only answers
    std::filesystem::path target;  ///< what lies there when it is done: its manifest or its answer
};

/// A job file's meaning: what to do, in order, and what not and why.
struct Job {
    std::filesystem::path file;
    std::filesystem::path folder;  ///< where everything is written
    std::string title;
    bool html = true;
    std::vector<JobStep> steps;
    std::vector<JobStep> build_stages;  ///< what make does instead of the step "build"
    std::vector<std::string> left_out;  ///< "curvature: no AOV asks for it"
};

/// Reads a job (docs/job.md). Relative paths are taken from the file's folder. ConfigError with
/// file:line for an unknown table or key (and the nearest name), a wrong type, a value out of range, no
/// input, or two views of one name; IoError if the file cannot be read.
Job read_job(const std::filesystem::path& file);

/// A Makefile that does what `slim run` does, the model stage by stage; `program_folder` holds the
/// executables. Targets are the steps' manifests, which are written last.
std::string makefile_of(const Job& job, const std::filesystem::path& program_folder);

/// The steps in order, then what is left out and why, for people.
std::string explanation_of(const Job& job);

}  // namespace slim
