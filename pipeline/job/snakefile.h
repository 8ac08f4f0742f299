#pragma once

#include "pipeline/job/job.h"
#include "pipeline/job/slurm_script.h"

#include <filesystem>
#include <string>

namespace slim {

/// A Snakefile (Snakemake 7) that does what `slim run` does, the model slice by slice: slicing is a
/// checkpoint, after which the slices are known. `job` was read from an absolute path. Outputs are
/// products and manifests; a rule's command is one of its params, so that changed options run it
/// again, and so does another version of the program.
std::string snakefile_of(const Job& job, const std::filesystem::path& programs,
                         const ClusterResources& resources);

}  // namespace slim
