#include "pipeline/info_stage.h"

#include "formats/fit_file.h"
#include "formats/model_file.h"
#include "formats/point_source.h"
#include "formats/slice_file.h"
#include "formats/truth_file.h"
#include "pipeline/json_text.h"
#include "pipeline/noise_over_diagonal.h"
#include "pipeline/plan_file.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kChunk = std::size_t{1} << 16;

json vector_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

bool finite(const Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Corners in the world, given a box in the local frame.
json bounds_json(const Bbox& box, const Vec3d& origin = {}) {
    if (box.empty()) return nullptr;
    return {{"min", vector_json(box.lo + origin)},
            {"max", vector_json(box.hi + origin)},
            {"diagonal", box.diagonal()}};
}

json parsed(const std::string& text) {
    const json value = json_or_discarded(text);
    return value.is_discarded() ? json(text) : value;
}

/// Counts by a small number, such as surfels per level: {"1": 12, "2": 40}.
class Tally {
public:
    void add(std::size_t i) { ++counts_[i]; }
    json to_json() const {
        json out = json::object();
        for (std::size_t i = 0; i < counts_.size(); ++i)
            if (counts_[i]) out[std::to_string(i)] = counts_[i];
        return out;
    }

private:
    std::array<std::uint64_t, 256> counts_{};
};

/// The options that the model was fitted with, as its provenance has them.
json fit_options(const json& provenance) {
    json out = json::object();
    if (!provenance.is_object() || !provenance.contains("rules")) return out;
    const json& rules = provenance.at("rules");
    out["degree"] = rules.value("choose_degree", false) ? json("auto") : rules.at("degree");
    for (const char* key : {"radius_rule", "weight", "cover", "sharp"})
        if (rules.contains(key)) out[key] = rules.at(key);
    return out;
}

/// Leaves that are not as asked, by cause, over all fits of the model.
json fallback_sums(const json& provenance) {
    std::map<std::string, std::uint64_t> sums;
    if (provenance.is_object() && provenance.contains("fits"))
        for (const json& fit : provenance.at("fits")) {
            const json by_cause = fit.value("fallbacks", json::object());
            for (const auto& [cause, n] : by_cause.items())
                sums[cause] += n.get<std::uint64_t>();
            for (const char* cause : {"forced", "contrary", "normals_disagree", "recentred"})
                sums[cause] += fit.value(cause, std::uint64_t{0});
        }
    return sums;
}

/// throws FormatError if the provenance is not what a model of this program says of itself
json provenance_info(const std::string& path, const json& provenance) {
    try {
        return {{"fit", fit_options(provenance)}, {"fallbacks", fallback_sums(provenance)}};
    } catch (const json::exception& error) {
        throw FormatError(fmt::format("{}: chunk provenance: {}", path, error.what()));
    }
}

/// Support radii of the leaves, model units; empty without any.
json leaf_radii(const SurfelTree& tree) {
    std::vector<double> radii;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf()) radii.push_back(tree.support_radius(i));
    if (radii.empty()) return json::object();
    const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
    std::nth_element(radii.begin(), middle, radii.end());
    const auto [least, most] = std::minmax_element(radii.begin(), radii.end());
    return {{"min", *least}, {"median", *middle}, {"max", *most}};
}

json model_info(const std::string& path) {
    const ModelFile file = ModelFile::open(path);
    const ModelHeader& header = file.header();
    const SurfelTree tree = file.tree();
    Tally levels, degrees, sheets;
    std::uint64_t saturated = 0, forced = 0, loose = 0;
    const json provenance = parsed(file.provenance_json());
    for (const SharpEntry& sharp : tree.sharp()) sheets.add(std::size_t{1} + sharp.n_extra);
    for (const TreeNode& node : tree.nodes().subspan(tree.n_nodes() ? 1 : 0)) {
        if (!node.is_leaf()) continue;
        levels.add(node.level);
        degrees.add(node.degree);
        saturated += (node.flags & kSaturated) != 0;
        forced += (node.flags & kForced) != 0;
        loose += node.is_loose();
    }
    const json said = provenance_info(path, provenance);
    return {{"kind", "model"},
            {"bytes", file.file_size()},
            {"degree", header.degree},
            {"colors", !file.colors().empty()},
            {"points", header.n_points},
            {"leaves", header.n_leaves},
            {"loose", loose},
            {"surfels", tree.n_nodes() ? tree.n_nodes() - 1 : 0},
            {"origin", vector_json(header.origin)},
            {"bounds", bounds_json(header.bounds, header.origin)},
            {"diagonal", header.diagonal},
            {"noise", noise_over_diagonal(header.noise_variance, header.diagonal)},
            {"t_mdl", header.mdl_threshold},
            {"seed", header.seed},
            {"leaf_radius", leaf_radii(tree)},
            {"leaves_by_level", levels.to_json()},
            {"leaves_by_degree", degrees.to_json()},
            {"sharp_leaves_by_sheets", sheets.to_json()},
            {"health",
             {{"checksums", "ok"},
              {"radius_at_the_largest", saturated},
              {"radius_not_chosen", forced}}},
            {"fit", said.at("fit")},
            {"fallbacks", said.at("fallbacks")},
            {"provenance", provenance}};
}

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

/// Totals of a cloud, gathered chunk by chunk.
struct CloudTotals {
    std::uint64_t points = 0, not_finite = 0, without_normal = 0;
    Bbox box;
    std::set<std::uint16_t> scans;

    void add(const PointChunk& chunk) {
        points += chunk.size();
        for (const Vec3d& p : chunk.position) {
            if (finite(p))
                box.extend(p);
            else
                ++not_finite;
        }
        for (const Vec3f& n : chunk.normal) {
            const float sq = dot(n, n);
            without_normal += !(sq > 0) || !std::isfinite(sq);
        }
        scans.insert(chunk.scan.begin(), chunk.scan.end());
    }
};

json cloud_json(const CloudInfo& info, const CloudTotals& totals) {
    json attributes = json::array();
    for (const std::string& name : info.carried) attributes.push_back(name);
    json out = {{"kind", "cloud"},
                {"format", info.format},
                {"bytes", info.file_size},
                {"points", totals.points},
                {"bounds", bounds_json(totals.box)},
                {"attributes", attributes},
                {"colors", info.colors.empty() ? "no" : "yes, read by slim build --color"},
                {"skipped", info.skipped},
                {"normals", info.faces_turned         ? "from faces, turned outwards"
                            : info.normals_from_faces ? "from faces"
                            : info.has_normals        ? "yes"
                                                      : "no"},
                {"truth", fs::exists(truth_path(info.path))},
                {"health", {{"not_finite", totals.not_finite}}}};
    if (info.has_normals) out["health"]["points_without_normal"] = totals.without_normal;
    if (info.has_scan) out["scans"] = totals.scans.size();
    if (info.origin) out["origin"] = vector_json(*info.origin);
    return out;
}

json cloud_info(const std::string& path, StageContext& context) {
    const std::unique_ptr<PointSource> source = open_cloud(path);
    CloudTotals totals;
    for (PointChunk chunk; source->read(chunk, kChunk);) {
        totals.add(chunk);
        context.reporter.progress("bytes read", source->bytes_read(), source->info().file_size);
    }
    json out = cloud_json(source->info(), totals);
    if (source->info().has_faces()) out["faces"] = source->info().n_faces;
    return out;
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
                               {"format", ""},
                               {"points", ""},
                               {"faces", ""},
                               {"normals", ""},
                               {"leaves", ""},
                               {"degree", ""},
                               {"colors", ""},
                               {"diagonal", "(L)"},
                               {"noise", "of L"},
                               {"bytes", ""}});
}

std::string first_bytes(const std::string& path, std::size_t n) {
    std::ifstream in(path, std::ios::binary);
    std::string head(n, '\0');
    in.read(head.data(), static_cast<std::streamsize>(n));
    head.resize(static_cast<std::size_t>(in.gcount()));
    return head;
}

json json_info(const std::string& path) {
    std::ifstream in(path);
    try {
        json contents = json_from(in);
        return {
            {"kind", "json"}, {"bytes", fs::file_size(path)}, {"contents", std::move(contents)}};
    } catch (const json::parse_error& error) {
        throw FormatError(fmt::format("{}: byte {}: not JSON: {}", path, error.byte, error.what()));
    }
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
        out = json_info(config.file);
    else
        out = cloud_info(config.file, context);
    out["file"] = config.file;
    context.text = summary_of(out);
    return out;
}

}  // namespace slim
