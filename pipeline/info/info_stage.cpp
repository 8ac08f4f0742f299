#include "pipeline/info/info_stage.h"

#include "formats/fit_file.h"
#include "formats/slice_file.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/info/info_cloud.h"
#include "pipeline/info/info_json.h"
#include "pipeline/info/info_model.h"
#include "pipeline/info/info_other.h"
#include "pipeline/info/info_record.h"
#include "slim/base/error.h"
#include "slim/model/surfel_tree.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

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

/// What the file is and how much of it first.
std::string summary_of(json info) {
    if (info.value("kind", "") == "model" && info.at("fit").value("degree", json()) == "auto")
        info["degree"] =
            fmt::format("auto: of each leaf its own, up to {}", info.at("degree").get<int>());
    drop_repeated(info);
    return summary_text(info, {{"file", ""},
                               {"kind", ""},
                               {"about", ""},
                               {"format", ""},
                               {"points", ""},
                               {"rows", ""},
                               {"columns", ""},
                               {"faces", ""},
                               {"normals", ""},
                               {"leaves", ""},
                               {"degree", ""},
                               {"colors", ""},
                               {"diagonal", "(L)"},
                               {"noise", "of L"},
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

}  // namespace

json run_info(const InfoConfig& config, StageContext& context) {
    if (fs::is_directory(config.file)) {
        const fs::path plan = plan_path(config.file),
                       page = fs::path(config.file) / "run.done.json";
        const fs::path inside = fs::exists(plan) ? plan : fs::exists(page) ? page : fs::path();
        throw ConfigError(fmt::format("{}: is a folder; expected a file{}", config.file,
                                      inside.empty() ? ": a model, a cloud or a file of a build"
                                                     : ", such as " + inside.string()));
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
        out = cloud_info(config.file, context);
    out["file"] = config.file;
    context.text = summary_of(out);
    return out;
}

}  // namespace slim
