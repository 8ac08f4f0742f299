#include "pipeline/manifest.h"

#include "formats/atomic_file.h"
#include "formats/slice_file.h"
#include "pipeline/file_hash.h"
#include "pipeline/json_text.h"
#include "pipeline/run_started.h"
#include "pipeline/version.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <fstream>
#include <set>

#include <unistd.h>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string hex(const XXH128_hash_t& hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

/// Of slices, which tell by their table what is in them: they are not read again for their hash.
json identity_json(const fs::path& file, const fs::path& shown, const std::string& identity) {
    return {{"path", shown.string()}, {"bytes", fs::file_size(file)}, {"identity", identity}};
}

json file_json(const fs::path& file, const fs::path& shown, const std::string& hash) {
    return {{"path", shown.string()}, {"bytes", fs::file_size(file)}, {"xxh3_128", hash}};
}

/// The manifest's folder may be moved as a whole: outputs in it are named relative to it.
fs::path relative_to(const fs::path& folder, const fs::path& file) {
    const fs::path whole = fs::absolute(file).lexically_normal();
    const fs::path relative = whole.lexically_relative(fs::absolute(folder).lexically_normal());
    return relative.empty() || *relative.begin() == ".." ? whole : relative;
}

fs::path folder_of(const fs::path& manifest) {
    return manifest.has_parent_path() ? manifest.parent_path() : fs::path(".");
}

std::string host_name() {
    char name[256] = {};
    return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

bool output_intact(const json& output, const fs::path& folder) {
    const fs::path file = folder / output.at("path").get<std::string>();
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error || bytes != output.at("bytes").get<std::uintmax_t>()) return false;
    return output.contains("identity")
               ? is_whole_slice(file.string(), output.at("identity").get<std::string>())
               : hash_file(file) == output.at("xxh3_128").get<std::string>();
}

/// Paths are for people; what must be equal is the contents.
json contents_of(json files) {
    for (json& file : files) file.erase("path");
    return files;
}

}  // namespace

fs::path manifest_path(const fs::path& output) { return output.string() + ".done.json"; }

fs::path manifest_path(const fs::path& folder, const std::string& stage) {
    return folder / (stage + ".done.json");
}

std::string hash_file(const fs::path& file) { return FileHash(file).finish(); }

std::string hash_text(const std::string& text) {
    return hex(XXH3_128bits(text.data(), text.size()));
}

json recorded_cost(const json& manifest) {
    return {{"seconds", manifest.at("seconds")},
            {"peak_memory_bytes", manifest.at("peak_memory_bytes")},
            {"run_started", manifest.value("run_started", manifest.at("finished"))}};
}

Stamp::Stamp(const StageContext& context, fs::path manifest)
    : context_(context), manifest_(std::move(manifest)), start_(std::chrono::steady_clock::now()) {}

void Stamp::input(const fs::path& file) { inputs_.push_back({file, false}); }
void Stamp::input(const fs::path& file, const std::string& identity) {
    inputs_.push_back({file, false, identity});
}
void Stamp::optional_input(const fs::path& file) { inputs_.push_back({file, true}); }
void Stamp::know_hash(const fs::path& file, const std::string& hash) {
    known_[file.string()] = hash;
    if (context_.written) (*context_.written)[file.string()] = hash;
}
void Stamp::depends(const std::string& text) { depends_ += text + "\n"; }
void Stamp::outputs(const std::vector<fs::path>& files) {
    outputs_.insert(outputs_.end(), files.begin(), files.end());
}

std::string Stamp::hash_of_input(const fs::path& file) const {
    if (const auto known = known_.find(file.string()); known != known_.end()) return known->second;
    if (context_.written) {
        const auto known = context_.written->find(file.string());
        if (known != context_.written->end()) return known->second;
    }
    return hash_file(file);
}

json Stamp::inputs_json() const {
    if (!hashed_.is_null()) return hashed_;
    hashed_ = json::array();
    for (const Input& input : inputs_) {
        if (input.optional && !fs::exists(input.path))
            hashed_.push_back({{"path", input.path.string()}, {"absent", true}});
        else if (!input.identity.empty() || is_slice_file(input.path.string()))
            hashed_.push_back(identity_json(
                input.path, input.path,
                input.identity.empty() ? slice_identity(input.path.string()) : input.identity));
        else
            hashed_.push_back(file_json(input.path, input.path, hash_of_input(input.path)));
    }
    return hashed_;
}

bool Stamp::outputs_intact(const json& recorded) const {
    const fs::path folder = folder_of(manifest_);
    std::set<std::string> wanted;
    for (const fs::path& output : outputs_) wanted.insert(relative_to(folder, output).string());
    for (const json& output : recorded) {
        const bool is_wanted = wanted.erase(output.at("path").get<std::string>()) > 0;
        if (!is_wanted && output.value("asked", false)) continue;
        if (!output_intact(output, folder)) return false;
    }
    return wanted.empty();
}

std::optional<json> Stamp::up_to_date() const {
    SLIM_CHECK(outputs_.size(), >, 0u);
    if (context_.force) return std::nullopt;
    std::ifstream in(manifest_);
    if (!in) return std::nullopt;
    try {
        const json manifest = json_from(in);
        if (manifest.at("program") != program_version() || manifest.at("stage") != context_.stage ||
            manifest.at("config_hash") != hash_text(context_.config + depends_) ||
            contents_of(manifest.at("inputs")) != contents_of(inputs_json()))
            return std::nullopt;
        if (!outputs_intact(manifest.at("outputs"))) return std::nullopt;
        json result = manifest.at("result");
        result["up_to_date"] = true;
        result["recorded"] = recorded_cost(manifest);
        context_.reporter.info(fmt::format("{}: up to date", context_.stage));
        return result;
    } catch (const json::exception&) {
        return std::nullopt;  // a damaged manifest only means that the work is done again
    }
}

json Stamp::output_json(const fs::path& file, bool asked) const {
    const fs::path shown = relative_to(folder_of(manifest_), file);
    json out;
    if (is_slice_file(file.string())) {
        out = identity_json(file, shown, slice_identity(file.string()));
    } else {
        const std::string hash = hash_file(file);
        if (context_.written) (*context_.written)[file.string()] = hash;
        out = file_json(file, shown, hash);
    }
    if (asked) out["asked"] = true;
    return out;
}

json Stamp::commit(json result, Outlasts outlasts, const std::vector<fs::path>& found) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start_;
    json manifest = {{"stage", context_.stage},
                     {"program", program_version()},
                     {"config", context_.config_toml},
                     {"settings", context_.config},
                     {"config_hash", hash_text(context_.config + depends_)},
                     {"depends", depends_},
                     {"inputs", inputs_json()},
                     {"outputs", json::array()},
                     {"result", result},
                     {"seconds", seconds.count()},
                     {"peak_memory_bytes", peak_.bytes()},
                     {"threads", context_.threads},
                     {"host", host_name()},
                     {"run_started", run_started()},
                     {"finished", utc_now()}};
    for (const fs::path& output : outputs_)
        manifest["outputs"].push_back(output_json(output, true));
    for (const fs::path& file : found)
        if (std::find(outputs_.begin(), outputs_.end(), file) == outputs_.end())
            manifest["outputs"].push_back(output_json(file, false));
    const std::string text = text_of(manifest, 2) + "\n";
    write_file_atomically(manifest_.string(), text, outlasts);
    return result;
}

}  // namespace slim
