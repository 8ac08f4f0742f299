#pragma once

#include "pipeline/build/plan_file.h"
#include "pipeline/job/job.h"

#include <filesystem>
#include <string>

namespace slim {

/// A Makefile (GNU make) that does what `slim run` does, the model slice by slice. `job` was read
/// from an absolute path, so that all paths are absolute; `programs` holds the executables.
///
/// Targets are manifests, which the steps write last. Each depends on what it reads and on a stamp
/// whose name holds the hash of the step's command line and of the program's version: another
/// option is another stamp, so that exactly this step and what follows from it are made again. A
/// missing product (a picture that was removed) makes its step run too. The file remakes itself
/// when the job changes. The slices are known after slicing only: their rules are a file of their
/// own, which make includes.
std::string makefile_of(const Job& job, const std::filesystem::path& programs);

/// The included part: normals and fits of every slice of a job that was sliced.
std::string slice_rules_of(const Job& job, const SlicePlan& plan,
                           const std::filesystem::path& programs);

}  // namespace slim
