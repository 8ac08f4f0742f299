#pragma once

#include "pipeline/report/report_row.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace slim {

/// How the steps of a report are run.
struct StepSettings {
    std::filesystem::path folder;         ///< for outputs and records; must exist
    std::uint64_t seed = 1;
    std::vector<std::string> programs;    ///< folders to look for commands in, before PATH
};

/// Whether this process makes the step's output itself: a cloud or a text.
bool is_made_here(const ReportStep& step);

/// What is known of a step before it is run.
struct PlannedStep {
    std::string name, output, program;
    std::vector<std::string> words, from;
    std::uint64_t points = 0;
    std::string missing;  ///< why it cannot be run: no program, or an input that is not there
};

/// Says how steps are run and what their outputs are called: NAME-HASH, the hash being of all that
/// decides what comes out (report_steps.h). Keeps the hashes of files outside the folder.
class StepPlanner {
public:
    StepPlanner(const StepSettings& settings, int threads)
        : settings_(settings), threads_(threads) {}

    /// throws ConfigError for a formula that is none, IoError for a file that cannot be read
    PlannedStep plan(const ReportStep& step, const ReportRow& row);

private:
    std::string fill(const ReportStep& step, const ReportRow& row, PlannedStep& out) const;
    void find_program(const ReportStep& step, PlannedStep& out) const;
    std::string program_path(const std::string& name) const;
    std::string key_of_files(const PlannedStep& planned);
    std::string hash_of(const std::string& file);

    const StepSettings& settings_;
    int threads_;
    std::map<std::string, std::string> hashes_;
};

}  // namespace slim
