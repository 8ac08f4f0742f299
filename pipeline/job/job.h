#pragma once

#include "pipeline/toml_file.h"
#include "slim/base/error.h"

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
    int line = 0;               ///< of the table of a view or of measures in the job file
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
    /// The model is there already: degree, color and sharp are what it has, the rest is empty.
    bool given = false;
};

/// What a model must be for a view to show something, as who reads the message can have it:
/// "degree = 3 in [fit]", or of a given model "a model built with --degree 3".
std::string model_remedy(const BuildStages& stages, const std::string& key,
                         const std::string& value);

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
    /// What views ask for alone and no model of this [fit] has; read_job refuses it.
    std::vector<ConfigError> refused;
    std::vector<std::string> left_out;  ///< "curvature: no AOV and no line asks for it"
    std::vector<std::string> uncertain;  ///< "view front: crease lines: drawn if ..."
    std::vector<std::string> missing;   ///< "view front: crest lines: they
                                        ///< need degree = 3 in [fit]"
};

/// Reads a job (docs/job.md), changed by the settings ("fit.t_mdl=0.02"). Relative paths are taken
/// from the file's folder. ConfigError with file:line for an unknown table or key (and the nearest
/// name), a wrong type, a value out of range, no input, or two views of one name; IoError if the
/// file cannot be read.
Job read_job(const std::filesystem::path& file, const std::vector<std::string>& settings = {});

/// The same of a job that asks for what its [fit] does not give: it says so (refused).
Job read_job_to_explain(const std::filesystem::path& file,
                        const std::vector<std::string>& settings = {});

/// What is drawn of a model that is there already, in place of what a job's [input] and [fit] make.
struct JobDrawing {
    std::filesystem::path model;
    BuildStages stages;              ///< what the model has; given
    std::filesystem::path folder;    ///< for the pictures, in place of [output] dir
    std::filesystem::path picture;   ///< of a job's one view, in place of a folder; empty: none
    /// Options of every view, which win over [render], [[light]] and the views' own; aov: over
    /// aovs. Their line is kOnCommandLine, their paths are absolute.
    std::vector<TomlValue> options;
};

/// The views of a job, and nothing else: its [input], [fit] and [measure] are not looked at.
/// ConfigError as read_job, for a job without a view, and for a picture of several views.
Job read_drawing(const std::filesystem::path& file, const JobDrawing& drawing);

/// Where the page's step leaves its manifest.
std::filesystem::path page_target(const Job& job);

/// What is refused, the steps in order, what is left out and why, and what will be missing, for
/// people.
std::string explanation_of(const Job& job);

}  // namespace slim
