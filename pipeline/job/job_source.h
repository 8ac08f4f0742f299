#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// Which job a command line names, and what it changes of it.
struct JobSource {
    std::string job;                    ///< file, or the name of a ready style
    std::vector<std::string> clouds;    ///< in place of the job's input
    std::string output;                 ///< in place of output.dir
    std::vector<std::string> settings;  ///< --set TABLE.KEY=VALUE

    template <class V>
    void visit(V&& field) {
        field.input("job", job,
                    "job file (TOML), or a ready style: plate, curvature, linework, terrain, "
                    "comparison, film");
        field.optional_input("clouds", clouds, "clouds in place of the job's own input");
        field.optional_output(
            "output", output,
            "folder in place of the job's own (with clouds: <first cloud>_<job> here)");
        field.settings(settings, "a key of the job is written TABLE.KEY, such as fit.t_mdl");
    }
};

/// The file: as it is named, or configs/styles/<name>.toml beside the program. ConfigError listing
/// the styles for any other name and for a cloud; for a style without a cloud, saying so.
std::filesystem::path job_file(const JobSource& source);

/// The file of a ready style that is named with nothing beside it, neither clouds nor anything that
/// would change it; else empty.
std::filesystem::path style_alone(const JobSource& source);

/// The settings, those that clouds and output stand for first.
std::vector<std::string> job_settings(const JobSource& source);

}  // namespace slim
