#pragma once

#include "pipeline/config.h"
#include "slim/base/reporter.h"
#include "slim/model/point_block.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace slim {

/// The points of a job's one slice, handed from a stage of a build to the next, which need not read
/// what was just written; nor need they be written where nobody keeps the work folder: a build of
/// one slice that was stopped begins again.
class HandedPoints {
public:
    explicit HandedPoints(bool instead_of_files = false) : instead_of_files_(instead_of_files) {}

    /// Whether what is put here is not written as well.
    bool instead_of_files() const { return instead_of_files_; }
    void put(std::string path, PointBlock points) {
        path_ = std::move(path);
        points_ = std::move(points);
    }
    /// The points that were written to that path. Nothing is held any more, whatever the path.
    std::optional<PointBlock> take(const std::string& path) {
        std::optional<PointBlock> out;
        if (path == path_) out = std::move(points_);
        path_.clear();
        points_ = {};
        return out;
    }

private:
    bool instead_of_files_;
    std::string path_;
    PointBlock points_;
};

/// A key of a result that people look for first, with the unit of its value, empty for none.
struct Headline {
    std::string key, unit;
};

/// What a stage is given besides its configuration. A stage called inside another one (build calls
/// slice) gets a context of its own: for_stage().
struct StageContext {
    Reporter& reporter;
    int threads = 1;          ///< in force already (ThreadLimit); for the manifest only
    bool force = false;       ///< do the work even if it is up to date
    std::string stage = {};        ///< "fit"
    std::string config = {};       ///< canonical_config: `key = value` per field that counts
    std::string config_toml = {};  ///< the whole resolved configuration
    /// if set: printed on stdout instead of the result's values (no --json)
    std::string text = {};
    std::vector<std::string> passed_on = {};  ///< common options for child processes: --threads=2
    /// Hashes of what the stages of one build wrote into its locked folder, so that none is read
    /// for its hash again.
    std::map<std::string, std::string>* written = nullptr;
    HandedPoints* handed = nullptr;  ///< within a build
    int threads_given = 0;           ///< by --threads; 0: `threads` are this
                                     ///< machine's or the environment's
    std::vector<Headline> headlines = {};  ///< if set: of this result, instead of the verb's
    /// keys that the command line or its --config says (see CommonOptions)
    std::vector<std::string> given = {};

    bool writes_handed_points() const { return !handed || !handed->instead_of_files(); }

    /// Throws Interrupted (exit 130, 143 or 4) if a signal asked to stop. Reporter::progress calls
    /// it too.
    void check_stop() const;
};

/// The name, one line and example command lines of a verb, for --help.
struct StageDescription {
    std::string name;                   ///< "fit": the executable is slim-fit
    std::string summary;                ///< one line
    std::vector<std::string> examples;  ///< "slim fit work --degree 2"
    bool answers = false;               ///< the result is the purpose: printed even with --quiet
    std::vector<Headline> headlines = {};  ///< of the summary: these first, the rest by name
};

/// A stage with its configuration's type erased, so that main's machinery is compiled once.
struct ErasedStage {
    StageDescription description;
    FieldList fields;
    std::function<nlohmann::json(StageContext&)> run;
    /// What --print-config prints instead of the fields; null or empty text: the fields.
    std::function<std::string()> resolved = {};
};

/// Set in the environment of a step that `slim run` starts: its parent says what went wrong.
inline constexpr const char* kErrorsByParent = "SLIM_ERRORS_BY_PARENT";
/// Whether `slim run` runs this step of a job: its reader changes keys of a job, not options.
bool runs_in_a_job();

/// A result for people: the headlines that it has first, then the rest by name.
std::string summary_text(const nlohmann::json& result, const std::vector<Headline>& headlines);

/// Parses, runs, prints and maps errors to exit codes (CONVENTIONS 2.1); never throws.
int run_erased_stage(const ErasedStage& stage, int argc, char** argv);

/// main() of one executable: the command line and config file (see FieldList), common options
/// (--config --set --print-config --threads --json --force -q -v --help --version), then
/// `run(config, context)`, whose JSON object is printed.
template <class Config, class Run>
int run_stage(StageDescription description, int argc, char** argv, Run run) {
    Config config;
    ErasedStage stage{std::move(description), fields_of(config),
                      [&](StageContext& context) { return run(config, context); }};
    return run_erased_stage(stage, argc, argv);
}

/// The same of a verb whose configuration is a file that it reads: --print-config prints what
/// resolved(config) makes of it, the fields where that is empty.
template <class Config, class Run, class Resolved>
int run_stage(StageDescription description, int argc, char** argv, Run run, Resolved resolved) {
    Config config;
    ErasedStage stage{std::move(description), fields_of(config),
                      [&](StageContext& context) { return run(config, context); },
                      [&] { return resolved(config); }};
    return run_erased_stage(stage, argc, argv);
}

/// The context of a stage called by another one: same reporter, threads and force, its own config.
template <class Config>
StageContext for_stage(const StageContext& parent, std::string stage, Config config) {
    const FieldList fields = fields_of(config);
    return {parent.reporter, parent.threads,       parent.force, std::move(stage),
            canonical_config(fields), print_config(fields), "", parent.passed_on};
}

}  // namespace slim
