#include "pipeline/build/cover_counts_json.h"

#include <algorithm>
#include <cstdint>
#include <string>

namespace slim {

nlohmann::json counts_json(const CoverCounts& c) {
    nlohmann::json fallbacks, degrees;
    for (std::size_t i = 1; i < kFallbacks; ++i)
        fallbacks[fallback_name(static_cast<Fallback>(i))] = c.fallbacks[i];
    for (std::size_t d = 0; d < c.degrees.size(); ++d)
        degrees[std::to_string(d)] = c.degrees[d];
    return {{"leaves", c.leaves},
            {"internals", c.internals},
            {"levels", c.levels},
            {"saturated", c.saturated},
            {"forced", c.forced},
            {"contrary", c.contrary},
            {"normals_disagree", c.normals_disagree},
            {"two_layers", c.two_layers},
            {"refitted", c.refitted},
            {"own", c.own},
            {"gaps_closed", c.gaps},
            {"needless", c.needless},
            {"recentred", c.recentred},
            {"sharp_edges", c.sharp_edges},
            {"sharp_corners", c.sharp_corners},
            {"sharp_rungs", c.sharp_rungs},
            {"dropped_unexplained", c.unexplained},
            {"dropped_isolated", c.isolated},
            {"dropped_beside", c.beside},
            {"searches", c.evaluated},
            {"searches_discarded", c.discarded},
            {"rungs", c.rungs},
            {"refinements", c.refinements},
            {"point_visits", c.point_visits},
            {"fallbacks", fallbacks},
            {"degrees", degrees}};
}

void add_counts(const nlohmann::json& one, nlohmann::json& sum) {
    if (sum.is_null()) sum = nlohmann::json::object();
    for (const auto& [key, value] : one.items()) {
        if (key == "recorded") continue;
        if (value.is_object()) {
            if (!sum.contains(key)) sum[key] = nlohmann::json::object();
            add_counts(value, sum[key]);
        } else if (key == "levels") {
            sum[key] = std::max(sum.value(key, std::uint64_t{0}), value.get<std::uint64_t>());
        } else if (value.is_number_unsigned()) {
            sum[key] = sum.value(key, std::uint64_t{0}) + value.get<std::uint64_t>();
        }
    }
}

}  // namespace slim
