#pragma once

#include "pipeline/report/report_row.h"

#include <filesystem>
#include <optional>
#include <string>

namespace slim {

/// The files of a step: all in the folder that begin with its name and a dot, without its record
/// and log, sorted.
std::vector<std::filesystem::path> files_of_step(const std::filesystem::path& folder,
                                                 const std::string& name);

/// Writes NAME.step.json: the figures, and sizes and hashes of the step's files.
void write_record(const std::filesystem::path& folder, const StepRecord& record);

/// Reads it back; nothing if there is none or a file is not as recorded (of a transient step files
/// need not be there).
std::optional<StepRecord> read_record(const std::filesystem::path& folder, const ReportStep& step,
                                      const std::string& name, const std::string& output);

}  // namespace slim
