#pragma once

#include "formats/atomic_file.h"
#include "pipeline/peak_memory.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// Where the manifest of an output lies: `<output>.done.json` beside a file;
/// `<dir>/<stage>.done.json` in a folder of many outputs.
std::filesystem::path manifest_path(const std::filesystem::path& output);
std::filesystem::path manifest_path(const std::filesystem::path& folder, const std::string& stage);

/// What a manifest says that its work cost: seconds, peak_memory_bytes and run_started, when the
/// run began that did it (in older ones when it ended). throws json::exception if it does not
nlohmann::json recorded_cost(const nlohmann::json& manifest);

/// The record of one finished piece of work, written last, so that its existence says "done":
/// program version, stage, config and its hash, sizes and XXH3-128 hashes of inputs and outputs (of
/// slices their identity, slice_identity(), in place of a hash), the result, seconds, peak memory
/// since the Stamp was made, threads, host, when its run began (run_started()) and it ended. Use:
///
///     Stamp stamp(context, manifest_path(config.output));
///     stamp.input(config.cloud);
///     stamp.outputs({config.output});
///     if (auto result = stamp.up_to_date()) return *result;
///     ... work ...
///     return stamp.commit(result);
///
/// Times, host, threads and paths stand here and never in a data file.
class Stamp {
public:
    /// The context must outlive the Stamp.
    Stamp(const StageContext& context, std::filesystem::path manifest);
    Stamp(StageContext&& context, std::filesystem::path manifest) = delete;

    /// Adds a file the outputs depend on (hashed when up_to_date or commit is called, a slice known
    /// by its table of checksums without a look at its points; IoError if it cannot be read,
    /// FormatError if it is a slice with a damaged table). Optional files that do not exist are
    /// recorded as absent.
    void input(const std::filesystem::path& file);
    /// The same for a file that says itself what distinguishes it, so that it need not be read.
    void input(const std::filesystem::path& file, const std::string& identity);
    void optional_input(const std::filesystem::path& file);
    /// The hash of an input whose bytes went through a FileHash as the work read them: neither this
    /// Stamp nor those of the same build read the file once more.
    void know_hash(const std::filesystem::path& file, const std::string& hash);
    /// Adds anything else the outputs depend on ("slice=3", a value from another stage's result).
    void depends(const std::string& text);
    /// Adds files that this command is asked to write. Stated once: up_to_date() asks the manifest
    /// for them and commit() records them, so that no name that an option gives is forgotten by
    /// either.
    void outputs(const std::vector<std::filesystem::path>& files);

    /// The recorded result, with "up_to_date": true and the seconds and peak memory of that run
    /// under "recorded", if the manifest fits program, stage, config and inputs, names every one of
    /// outputs(), and these and what else the work has written are there with their recorded bytes:
    /// all of them read, of slices too (is_whole_slice). Files that another command asked for
    /// besides are of no concern. Empty with --force. Without any outputs() it is a SLIM_CHECK
    /// failure.
    std::optional<nlohmann::json> up_to_date() const;

    /// Hashes the outputs, slices apart, and files that only the work could know of (`found`), and
    /// writes the manifest (temporary name, then rename). Returns `result`. What stands in a work
    /// folder need not outlast a power cut: the hashes show what was lost.
    nlohmann::json commit(nlohmann::json result, Outlasts outlasts = Outlasts::power_cut,
                          const std::vector<std::filesystem::path>& found = {});

private:
    struct Input {
        std::filesystem::path path;
        bool optional;
        std::string identity = {};
    };
    nlohmann::json inputs_json() const;
    bool outputs_intact(const nlohmann::json& recorded) const;
    nlohmann::json output_json(const std::filesystem::path& file, bool asked) const;
    std::string hash_of_input(const std::filesystem::path& file) const;

    const StageContext& context_;
    std::filesystem::path manifest_;
    std::vector<Input> inputs_;
    std::vector<std::filesystem::path> outputs_;
    std::string depends_;
    std::map<std::string, std::string> known_;  // hashes by path
    std::chrono::steady_clock::time_point start_;
    PeakMeter peak_;
    mutable nlohmann::json hashed_;  // inputs_json(), made once
};

/// XXH3-128 of a file's bytes as 32 hex digits. IoError if it cannot be read.
std::string hash_file(const std::filesystem::path& file);
std::string hash_text(const std::string& text);

}  // namespace slim
