#include "pipeline/info/info_stage.h"

#include "formats/cloud_kind.h"
#include "formats/fit_file.h"
#include "formats/slice_file.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/info/info_cloud.h"
#include "pipeline/info/info_json.h"
#include "pipeline/info/info_model.h"
#include "pipeline/info/info_other.h"
#include "pipeline/info/info_record.h"
#include "pipeline/info/info_toml.h"
#include "slim/base/error.h"
#include "slim/model/surfel_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json slice_info(const std::string& path) {
    const PointBlock block = read_slice(path);
    Bbox box;
    for (const Vec3d& p : block.position) box.extend(p);
    std::uint64_t without_normal = 0;
    for (const Vec3f& n : block.normal) without_normal += dot(n, n) == 0;
    json attributes = json::array({"id"});
    if (block.has_normals()) attributes.push_back("normal");
    if (block.has_scans()) attributes.push_back("scan");
    return {{"kind", "slice"},
            {"bytes", fs::file_size(path)},
            {"points", block.size()},
            {"origin", vector_json(block.origin)},
            {"bounds", bounds_json(box, block.origin)},
            {"attributes", attributes},
            {"health", {{"checksums", "ok"}, {"points_without_normal", without_normal}}}};
}

json fit_info(const std::string& path) {
    const FitFile fit = read_fit(path);
    Tally levels;
    std::uint64_t leaves = 0;
    for (const FittedSurfel& surfel : fit.surfels) {
        levels.add(surfel.level);
        leaves += (surfel.flags & kLeaf) != 0;
    }
    return {{"kind", "fit"},          {"bytes", fs::file_size(path)},
            {"surfels", fit.surfels.size()}, {"leaves", leaves},
            {"surfels_by_level", levels.to_json()}, {"health", {{"checksums", "ok"}}},
            {"header", parsed(fit.header_json)}};
}

/// What stands in a result twice is said once: a model's diagonal and degree, and of its provenance
/// the counts and rules that --json has whole.
void drop_repeated(json& info) {
    if (info.contains("diagonal")) info["bounds"].erase("diagonal");
    if (info.contains("fit") && info.at("fit").contains("degree")) info["fit"].erase("degree");
    if (!info.contains("provenance") || !info.at("provenance").is_object()) return;
    for (const char* key : {"fits", "rules", "orphans", "childless"}) info["provenance"].erase(key);
}

/// Up to eight names, and how many more there are.
std::string some_of(const json& files) {
    constexpr std::size_t kMost = 8;
    std::vector<std::string> names;
    for (const json& file : files)
        if (names.size() < kMost) names.push_back(file.at("path").get<std::string>());
    const std::string more =
        files.size() > kMost ? fmt::format(" and {} more", files.size() - kMost) : "";
    return names.empty() ? "none" : fmt::format("{}{}", fmt::join(names, ", "), more);
}

/// Of a manifest what a person looks for: what was made of what, when and at what cost.
void shorten_manifest(json& info) {
    const json whole = info.at("contents");
    info.erase("contents");
    for (const char* key :
         {"stage", "program", "finished", "host", "threads", "seconds", "peak_memory_bytes"})
        if (whole.contains(key)) info[key] = whole.at(key);
    for (const char* key : {"inputs", "outputs"})
        if (whole.contains(key)) info[key] = some_of(whole.at(key));
    info["rest"] = "settings, hashes and results: --json";
}

/// Without what would fill a screen; --json has it.
json shortened(json info) {
    const std::string kind = info.value("kind", "");
    if (kind == "manifest") shorten_manifest(info);
    if (kind == "model") info = model_in_short(std::move(info));
    if (info.contains("tables")) info = toml_in_short(std::move(info));
    if (info.contains("metadata") && info.at("metadata").contains("slim:config"))
        info["metadata"]["slim:config"] = "all options of the picture: --json";
    return info;
}

/// What the file is and how much of it first.
std::string summary_of(json info) {
    try {
        info = shortened(info);
    } catch (const json::exception&) {  // a manifest that someone edited: whole, then
    }
    if (info.value("kind", "") == "model" && info.at("fit").value("degree", json()) == "auto")
        info["degree"] =
            fmt::format("auto: of each leaf its own, up to {}", info.at("degree").get<int>());
    drop_repeated(info);
    const char* const noise =
        info.value("kind", "") == "cloud" ? "of L, the diagonal, before it was smoothed" : "of L";
    return summary_text(info, {{"file", ""},
                               {"kind", ""},
                               {"about", ""},
                               {"format", ""},
                               {"points", ""},
                               {"input", ""},
                               {"scan", ""},
                               {"fit", ""},
                               {"render", ""},
                               {"views", ""},
                               {"experiments", ""},
                               {"rows", ""},
                               {"columns", ""},
                               {"faces", ""},
                               {"normals", ""},
                               {"leaves", ""},
                               {"degree", ""},
                               {"colors", ""},
                               {"diagonal", "(L)"},
                               {"noise", noise},
                               {"noise_typical", "of L, at a typical place"},
                               {"bytes", ""}});
}

std::string first_bytes(const std::string& path, std::size_t n) {
    std::ifstream in(path, std::ios::binary);
    std::string head(n, '\0');
    in.read(head.data(), static_cast<std::streamsize>(n));
    head.resize(static_cast<std::size_t>(in.gcount()));
    return head;
}

constexpr const char* kKinds =
    "a model (.slim), a cloud (PLY, or text of coordinates; also .gz), a slice or fit of a build, "
    "JSON, a job, report or options (.toml), a picture (.png, .exr), a drawing (.svg), a page "
    "(.html), lines (.obj), a table (.csv), a log, the truth of a cloud (.truth) or what 'slim "
    "plan' prints";

/// "text that begins 'SLIM turns ...'", or the first bytes of what is none.
std::string what_it_seems(const std::string& head) {
    const auto is_text = [](unsigned char c) { return c >= 0x20 || (c >= '\t' && c <= '\r'); };
    if (std::all_of(head.begin(), head.end(), is_text)) {
        const std::size_t first = std::min(head.find_first_not_of(" \t\r\n"), head.size());
        const std::size_t end = head.find_first_of("\r\n", first);
        return "text that begins '" + head.substr(first, end - first) + "'";
    }
    std::string bytes;
    for (std::size_t i = 0; i < std::min<std::size_t>(head.size(), 8); ++i)
        bytes += fmt::format(" {:02x}", static_cast<unsigned char>(head[i]));
    return "bytes of no format that is known, the first" + bytes;
}

/// As a cloud's text does: what is wrong with one is told by line.
bool begins_with_number(const std::string& head) {
    const std::size_t first = head.find_first_not_of(" \t\r\n+-.");
    return first != std::string::npos && head[first] >= '0' && head[first] <= '9';
}

/// A cloud, by whatever name; what is none, and is not named as one, may be anything.
json cloud_or_unknown(const std::string& path, StageContext& context) {
    const std::string head = first_bytes(path, 60);
    try {
        return cloud_info(path, context);
    } catch (const FormatError&) {
        if (head.empty() || is_known_format(path, head) || begins_with_number(head)) throw;
        throw FormatError(Fault{.file = path,
                                .problem = "is of no kind that is known",
                                .expected = kKinds,
                                .found = what_it_seems(head)});
    }
}

}  // namespace

json run_info(const InfoConfig& config, StageContext& context) {
    if (fs::is_directory(config.file)) {
        const fs::path plan = plan_path(config.file),
                       page = fs::path(config.file) / "run.done.json";
        const fs::path inside = fs::exists(plan) ? plan : fs::exists(page) ? page : fs::path();
        throw ConfigError({.file = config.file,
                           .problem = "is a folder",
                           .expected = inside.empty()
                                           ? "a file: a model, a cloud or a file of a build"
                                           : "a file, such as " + inside.string()});
    }
    const std::string head = first_bytes(config.file, 8);
    json out;
    if (head == "SLIMTREE")
        out = model_info(config.file);
    else if (head == "SLIMSLCE")
        out = slice_info(config.file);
    else if (head == "SLIMFITS")
        out = fit_info(config.file);
    else if (config.file.ends_with(".json"))
        out = record_info(config.file);
    else if (auto other = other_info(config.file))
        out = std::move(*other);
    else
        out = cloud_or_unknown(config.file, context);
    out["file"] = config.file;
    context.text = summary_of(out);
    return out;
}

}  // namespace slim
