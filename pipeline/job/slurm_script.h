#pragma once

#include "pipeline/build/plan_file.h"
#include "pipeline/job/job.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace slim {

/// What each job asks of the cluster.
struct ClusterResources {
    int threads = 1;
    std::uint64_t memory_bytes = 0;
};

/// A shell script that submits to Slurm what `slim run` does: the scan, slicing, and a step that
/// goes on once the slices are known. `job` was read from an absolute path. Each step is a job that
/// starts after those it reads from have ended well; what is up to date says so within
/// milliseconds, so that the script run again goes on where it was.
std::string slurm_script_of(const Job& job, const std::filesystem::path& programs,
                            const ClusterResources& resources);

/// The script's second part, for the slices of a job that was sliced: normals and fits as array
/// jobs, the build, measures, views and what joins the shares of divided ones as array jobs, and
/// the page.
std::string slurm_slices_of(const Job& job, const SlicePlan& plan,
                            const std::filesystem::path& programs,
                            const ClusterResources& resources);

}  // namespace slim
