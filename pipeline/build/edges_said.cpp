#include "pipeline/build/edges_said.h"

#include <fmt/format.h>

#include <cstdint>

namespace slim {

nlohmann::json sharp_json(const CoverRules& rules, const Cover& cover) {
    nlohmann::json out{{"sharp", rules.sharp}};
    if (rules.ask_for_edges)
        out = {{"sharp", cover.edges.are_features()},
               {"edge_share", cover.edges.share()},
               {"edge_places", cover.edges.asked}};
    if (cover.are_on_faces) out["on_faces"] = true;
    return out;
}

nlohmann::json sharp_of(const nlohmann::json& result) {
    nlohmann::json out = nlohmann::json::object();
    for (const char* key : {"sharp", "edge_share", "edge_places", "on_faces", "sharp_by_faces"})
        if (result.contains(key)) out[key] = result.at(key);
    return out;
}

std::string edges_text(const nlohmann::json& result, Remedies remedies) {
    const auto with = [&](const char* value, const char* comes) {
        return remedies == Remedies::of_a_job
                   ? fmt::format("(fit.sharp = \"{}\": {})", value, comes)
                   : fmt::format("(--sharp {}: {})", value, comes);
    };
    const auto is_true = [&](const char* key) {
        return result.contains(key) && result.at(key) == true;
    };
    if (is_true("sharp_by_faces"))
        return "sharp edges: a mesh of large faces: with sharp surfels " + with("off", "without");
    // A manifest may have been edited.
    if (!result.contains("edge_share") || !result.at("edge_share").is_number() ||
        !result.contains("edge_places") || !result.at("edge_places").is_number_unsigned())
        return "";
    const bool sharp = is_true("sharp");
    const auto places = result.at("edge_places").get<std::uint64_t>();
    if (places == 0)
        return "too few points to tell edges by: no sharp surfels " + with("on", "with");
    return fmt::format("sharp edges: at {:.1f} % of the {} places looked at, {} {:.1f} %: {}{}",
                       100 * result.at("edge_share").get<double>(), places,
                       sharp ? "above" : "not above", 100 * kEdgeShare,
                       sharp ? "with sharp surfels " + with("off", "without")
                             : "without sharp surfels " + with("on", "with"),
                       is_true("on_faces") ? ", of points moved onto faces (noise)" : "");
}

}  // namespace slim
