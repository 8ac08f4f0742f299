#pragma once

#include "pipeline/build/plan_file.h"
#include "pipeline/job/job.h"

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// What every form of a plan (make, Slurm, Snakemake) says of a job's steps. Commands are lists of
/// words, the program's absolute path first.
using Words = std::vector<std::string>;

Words verb_command(const std::filesystem::path& programs, const std::string& verb,
                   const Words& arguments);

/// The job and what was changed of it, as words for run and plan.
Words job_words(const Job& job);

/// The manifest of what makes a file, or the file itself if no step does.
std::filesystem::path made_by(const std::filesystem::path& file, const Job& job);

/// The build that joins what the slices' steps have made: it finds them up to date.
Words joining_build(const JobStep& step, const Job& job, const std::filesystem::path& programs);

/// A step as plans run it: as a whole, or as the tasks that share it and the one that joins these.
struct PlanTask {
    Words command;
    std::vector<std::filesystem::path>
        needs;                     ///< files that other steps make, and shares, by their manifests
    std::filesystem::path target;  ///< its manifest
    std::vector<std::filesystem::path> products;  ///< files that must be there when it is done
};
PlanTask whole_task(const JobStep& step, const Job& job, const std::filesystem::path& programs);
/// Those that share a step; none of a step that is one task.
std::vector<PlanTask> share_tasks(const JobStep& step, const Job& job,
                                  const std::filesystem::path& programs);
/// What makes one of them.
PlanTask join_task(const JobStep& step, const Job& job, const std::filesystem::path& programs);

/// Whether slices take the signs of their normals from the slice before, so that they run in order.
bool normals_in_order(const Job& job, const SlicePlan& plan);

}  // namespace slim
