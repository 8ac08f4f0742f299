#include "pipeline/info/info_model.h"

#include "formats/model_file.h"
#include "pipeline/info/info_json.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/noise_over_diagonal.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

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

/// By which share of places at edges, or that by its large faces, the build decided about sharp
/// surfels: of its manifest beside the model, if this is still the file that it wrote; nothing of
/// others, and where an option decided.
json edges_of_build(const std::string& path) {
    std::ifstream in(manifest_path(path));
    const json manifest = json_or_discarded(in);
    json out = json::object();
    if (!manifest.is_object() || !manifest.contains("result")) return out;
    const json& result = manifest.at("result");
    if (!result.is_object()) return out;
    for (const char* key : {"edge_share", "edge_places", "sharp_by_faces"})
        if (result.contains(key)) out[key] = result.at(key);
    if (out.empty()) return out;
    const std::string hash = hash_file(path);
    const json outputs = manifest.contains("outputs") ? manifest.at("outputs") : json::array();
    for (const json& file : outputs)
        if (file.is_object() && file.contains("xxh3_128") && file.at("xxh3_128") == hash)
            return out;
    return json::object();
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

/// Points that the fits left out, by cause.
json dropped_sums(const json& provenance) {
    std::map<std::string, std::uint64_t> sums;
    if (provenance.is_object() && provenance.contains("fits"))
        for (const json& fit : provenance.at("fits"))
            for (const char* cause : {"isolated", "beside", "unexplained"})
                sums[cause] += fit.value(std::string("dropped_") + cause, std::uint64_t{0});
    return sums;
}

/// throws FormatError if the provenance is not what a model of this program says of itself
json provenance_info(const std::string& path, const json& provenance) {
    try {
        return {{"fit", fit_options(provenance)},
                {"fallbacks", fallback_sums(provenance)},
                {"dropped", dropped_sums(provenance)}};
    } catch (const json::exception&) {
        throw FormatError(Fault{.file = path,
                                .problem = "chunk provenance",
                                .expected = "the fit, fallbacks and dropped points as `slim build` "
                                            "writes them",
                                .found = "other values"});
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

/// Leaves of a tree by kind.
struct LeafCounts {
    Tally levels, degrees, sheets;
    std::uint64_t saturated = 0, forced = 0, loose = 0;

    explicit LeafCounts(const SurfelTree& tree) {
        for (const SharpEntry& sharp : tree.sharp()) sheets.add(std::size_t{1} + sharp.n_extra);
        for (const TreeNode& node : tree.nodes().subspan(tree.n_nodes() ? 1 : 0)) {
            if (!node.is_leaf()) continue;
            levels.add(node.level);
            degrees.add(node.degree);
            saturated += (node.flags & kSaturated) != 0;
            forced += (node.flags & kForced) != 0;
            loose += node.is_loose();
        }
    }
};

}  // namespace

json model_info(const std::string& path) {
    const ModelFile file = ModelFile::open(path);
    const ModelHeader& header = file.header();
    const SurfelTree tree = file.tree();
    const LeafCounts leaves(tree);
    const json provenance = parsed(file.provenance_json());
    json said = provenance_info(path, provenance);
    said["fit"].update(edges_of_build(path));
    const json& rules = provenance.contains("rules") ? provenance.at("rules") : json::object();
    json info = {{"kind", "model"},
            {"bytes", file.file_size()},
            {"degree", header.degree},
            {"colors", !file.colors().empty()},
            {"points", header.n_points},
            {"leaves", header.n_leaves},
            {"loose", leaves.loose},
            {"surfels", tree.n_nodes() ? tree.n_nodes() - 1 : 0},
            {"origin", vector_json(header.origin)},
            {"bounds", bounds_json(header.bounds, header.origin)},
            {"diagonal", header.diagonal},
            {"noise", noise_over_diagonal(header.noise_variance, header.diagonal)},
            {"t_mdl", header.mdl_threshold},
            {"seed", header.seed},
            {"leaf_radius", leaf_radii(tree)},
            {"leaves_by_level", leaves.levels.to_json()},
            {"leaves_by_degree", leaves.degrees.to_json()},
            {"sharp_leaves_by_sheets", leaves.sheets.to_json()},
            {"health",
             {{"checksums", "ok"},
              {"radius_at_the_largest", leaves.saturated},
              {"radius_not_chosen", leaves.forced}}},
            {"fit", said.at("fit")},
            {"fallbacks", said.at("fallbacks")},
            {"dropped", said.at("dropped")},
            {"provenance", provenance}};
    // Older models do not say it.
    if (rules.is_object() && rules.contains("typical_variance") &&
        rules.at("typical_variance").is_number())
        info["noise_typical"] = noise_over_diagonal(
            std::min(rules.at("typical_variance").get<double>(), header.noise_variance),
            header.diagonal);
    return info;
}

namespace {

using Words = std::pair<const char*, const char*>;

constexpr Words kOfLeaves[] = {
    {"few_points", "of a lower degree: too few points"},
    {"rank", "of a lower degree: the points do not span more"},
    {"steep", "of a lower degree: a fit that is too steep"},
    {"plane", "planes: nothing else fits"},
    {"lower_explains", "of a lower degree, which explains the points"},
    {"forced", "of the smallest radius, with more error than asked"},
    {"contrary", "cut short at a fold or another sheet"},
    {"normals_disagree", "over points whose normals disagree"},
    {"recentred", "moved inwards from a border"}};
constexpr Words kOfPoints[] = {{"isolated", "strays: too few neighbours"},
                               {"beside", "of rims, left to the surface beside them"},
                               {"unexplained", "that no surfel explains"}};

/// Counts by what they are of; those of 0 are left out, and "none" is left if all are.
json in_words(const json& counts, std::span<const Words> words) {
    json out = json::object();
    for (const auto& [key, text] : words)
        if (const auto n = counts.value(key, std::uint64_t{0})) out[text] = n;
    return out;
}

}  // namespace

json model_in_short(json info) {
    info["leaves not as asked"] = in_words(info.at("fallbacks"), kOfLeaves);
    info["points left out"] = in_words(info.at("dropped"), kOfPoints);
    info.erase("fallbacks"), info.erase("dropped");
    return info;
}

}  // namespace slim
