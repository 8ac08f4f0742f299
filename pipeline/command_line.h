#pragma once

#include "pipeline/stage.h"

#include <string>
#include <vector>

namespace slim {

/// What every verb understands besides its own fields.
struct CommonOptions {
    bool help = false;
    bool version = false;
    bool print_config = false;
    bool json = false;
    bool quiet = false;
    bool verbose = false;
    bool force = false;
    int threads = 0;  ///< 0: SLIM_THREADS, SLURM_CPUS_PER_TASK or the process's share
    std::string config;
    std::vector<std::string> set;    ///< key=value
    /// keys that these, the options or the file say, once each; of a file that names all keys, as
    /// --print-config prints it, those not as by default
    std::vector<std::string> given;
};

/// Fills the fields from --config FILE, then --set, then the options and words themselves (the
/// later win); checks nothing if help or version is asked. ConfigError naming the argument and, if
/// it is unknown, the nearest one.
CommonOptions parse_command_line(int argc, char** argv, const FieldList& fields);

/// What --help prints: usage, the fields with defaults and ranges, common options, examples.
std::string help_text(const StageDescription& stage, const FieldList& fields);

}  // namespace slim
