#pragma once

#include "pipeline/job/job.h"
#include "pipeline/toml_file.h"

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// What the pictures of a job are made of.
struct JobPictures {
    const std::filesystem::path& file;
    const TomlTable& root;
    const std::vector<std::string>& usual_aovs;  ///< of a view that names none
    const std::filesystem::path& model;
    /// of the one view; empty: named in the job's folder
    const std::filesystem::path picture = {};
    /// The command line changed what is drawn: what the file says in vain then is left out.
    bool overridden = false;
};

/// Reads [render], [[light]] and [[view]]: adds a step for each view, and what no view asks for to
/// what is left out. Options of [render] that a view has no use for are left out of it
/// (options_for); ConfigError for one that none takes.
void read_job_views(const JobPictures& pictures, Job& job);

}  // namespace slim
