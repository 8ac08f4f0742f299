#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// A part of a step that is a task of its own in plans.
struct JobShare {
    std::string option;            ///< "--share=2/8", beside the step's arguments
    std::filesystem::path target;  ///< its manifest
    std::vector<std::filesystem::path> products;
};

/// One command of a job: slim-<verb> with its arguments.
struct JobStep {
    std::string name;  ///< "scan", "build", "measure cloud.ply", "view front"
    std::string verb;
    std::vector<std::string> arguments;
    /// files it reads (outputs of earlier steps among them)
    std::vector<std::filesystem::path> inputs;
    std::filesystem::path output;               ///< what -o names
    std::filesystem::path target;               ///< its manifest, written last
    std::vector<std::filesystem::path> products;  ///< files that must be there when it is done
    /// tasks among which plans divide it, before one with --join puts it together; none: it is one
    std::vector<JobShare> shares = {};
    std::string division = {};  ///< why it is divided, or a large one not, for people
};

/// The stages of the step "build", as make runs them: slice by slice. Arguments without --slice.
struct BuildStages {
    std::filesystem::path work;
    std::filesystem::path slice_target;  ///< the manifest of slicing
    std::vector<std::string> slice, normals, fit;
    bool estimate_normals = false;  ///< whatever normals the clouds have
    std::string memory;             ///< for points
    std::string degree;             ///< of surfels: "1", "2", "3", "auto"
    bool color = false;             ///< the model keeps the clouds' colours
    std::string sharp;              ///< whether it has sharp surfels: "auto", "on", "off"
};

/// A job file's meaning: what to do, in order, and what not and why.
struct Job {
    std::filesystem::path file;
    std::vector<std::string> settings;     ///< what was changed of it by --set
    std::filesystem::path folder;  ///< where everything is written
    std::string title;
    std::string unit;  ///< of length, as [render] names it
    bool html = true;
    std::vector<JobStep> steps;
    BuildStages stages;
    std::vector<std::string> left_out;  ///< "curvature: no AOV and no line asks for it"
    std::vector<std::string> uncertain;  ///< "view front: crease lines: drawn if the points ..."
    std::vector<std::string> missing;   ///< "view front: crest lines: they
                                        ///< need degree = 3 in [fit]"
};

/// Reads a job (docs/job.md), changed by the settings ("fit.t_mdl=0.02"). Relative paths are taken
/// from the file's folder. ConfigError with file:line for an unknown table or key (and the nearest
/// name), a wrong type, a value out of range, no input, or two views of one name; IoError if the
/// file cannot be read.
Job read_job(const std::filesystem::path& file, const std::vector<std::string>& settings = {});

/// Where the page's step leaves its manifest.
std::filesystem::path page_target(const Job& job);

/// The steps in order, what is left out and why, and what will be missing, for people.
std::string explanation_of(const Job& job);

}  // namespace slim
