#include "pipeline/job/job_source.h"

#include "pipeline/child_process.h"
#include "pipeline/config.h"
#include "pipeline/input_kind.h"
#include "pipeline/shell_word.h"
#include "pipeline/toml_file.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// Where ready styles lie: in the source tree that the program was built in, beside the programs
/// (in a copy of their folder), or installed. The first that is there;
/// else the one that a copy has.
fs::path style_folder() {
    const fs::path here = program_folder(), beside = here / "styles";
    for (const fs::path& folder :
         {here / "../../configs/styles", beside, here / "../share/slim/styles"}) {
        std::error_code error;
        if (fs::is_directory(folder, error)) return folder;
    }
    return beside;
}

std::vector<std::string> style_names() {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(style_folder(), error))
        if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// A TOML string.
std::string quoted(std::string text) {
    return Field("", Field::Target(&text), "", FieldRole::option).toml();
}

std::string absolute(const std::string& path) {
    return fs::absolute(path).lexically_normal().string();
}

/// The path as a TOML string. ConfigError for a name that TOML does not hold.
std::string quoted_path(const std::string& path) {
    const std::string text = quoted(absolute(path));
    try {
        TomlTable any;
        set_value(any, "any.files=[" + text + "]");
    } catch (const ConfigError&) {  // all but that is escaped
        throw ConfigError({.file = path,
                           .problem = "a name that is no UTF-8, which a job cannot hold",
                           .expected = "another name, or a link to it"});
    }
    return text;
}

/// Whether the command line says what to read.
bool names_input(const JobSource& source) {
    return !source.clouds.empty() ||
           std::any_of(source.settings.begin(), source.settings.end(),
                       [](const auto& text) { return text.starts_with("input."); });
}

/// A file that is there, or a name that no style has. A folder of results may have a style's.
bool is_path(const fs::path& job) {
    return (fs::exists(job) && !fs::is_directory(job)) || job.has_extension() ||
           job.has_parent_path();
}

/// The ready style of that name, empty if there is none.
fs::path style_file(const std::string& name) {
    const fs::path file = style_folder() / (name + ".toml");
    return fs::exists(file) ? fs::weakly_canonical(file) : fs::path();
}

}  // namespace

fs::path style_alone(const JobSource& source) {
    const bool is_alone = source.clouds.empty() && source.output.empty() && source.settings.empty();
    return is_alone && !is_path(source.job) ? style_file(source.job) : fs::path();
}

fs::path job_file(const JobSource& source) {
    const fs::path named = source.job;
    const InputKind kind = input_kind(named);
    if (kind == InputKind::model)
        throw ConfigError({.file = source.job,
                           .problem = "a model, not a job",
                           .expected = "a job file (TOML)"});
    if (kind == InputKind::cloud)
        throw ConfigError(
            {.file = source.job,
             .problem = "a point cloud, not a job",
             .expected = fmt::format("a job file or a ready style before it, such as: {}",
                                     shell_line({"slim", "run", "plate", source.job})),
             .hint = fmt::format("styles: {}", fmt::join(style_names(), ", "))});
    if (is_path(source.job)) return named;
    if (const fs::path file = style_file(source.job); !file.empty()) {
        if (!names_input(source))
            throw ConfigError(
                {.file = source.job,
                 .problem = fmt::format("a ready style is for clouds that are named after it: "
                                        "slim run {} scan.ply",
                                        source.job)});
        return file;
    }
    const auto known = style_names();
    if (known.empty())
        throw ConfigError(
            {.file = source.job,
             .problem = "no such job file, and there are no ready styles beside the program",
             .expected = "them in " + style_folder().string(),
             .hint = "they are configs/styles of the source"});
    throw ConfigError({.file = source.job,
                       .problem = "no such job file, and no ready style of that name",
                       .expected = fmt::format("a file, or one of {}", fmt::join(known, ", ")),
                       .hint = did_you_mean(source.job, known)});
}

std::vector<std::string> job_settings(const JobSource& source) {
    std::vector<std::string> settings;
    if (!source.clouds.empty()) {
        std::vector<std::string> files;
        for (const std::string& cloud : source.clouds) files.push_back(quoted_path(cloud));
        settings.push_back(fmt::format("input.files=[{}]", fmt::join(files, ", ")));
    }
    std::string folder = source.output;
    if (folder.empty() && !source.clouds.empty())
        folder =
            fs::path(source.clouds[0]).stem().string() + "_" + fs::path(source.job).stem().string();
    if (!folder.empty()) settings.push_back("output.dir=" + quoted_path(folder));
    settings.insert(settings.end(), source.settings.begin(), source.settings.end());
    return settings;
}

}  // namespace slim
