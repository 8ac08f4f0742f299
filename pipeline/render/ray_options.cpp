#include "pipeline/render/ray_options.h"

#include "pipeline/contains.h"
#include "pipeline/option_names.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_uses.h"
#include "pipeline/render/render_view.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace slim {
namespace {

constexpr const char* kOneModel = " shows the colours of one model: leave out --add";

/// An option that is asked for, and what of it where it is not all.
struct Asked {
    const char* key;
    const char* what;
};

/// What is asked for that only rays can do.
std::vector<Asked> asked_of_rays(const RenderConfig& config,
                                 const std::vector<std::string>& aovs) {
    std::vector<Asked> asked;
    if (contains(aovs, "ao")) asked.push_back({"aov", " ao"});
    if (config.ao) asked.push_back({"ao", ""});
    if (config.ground) asked.push_back({"ground", ""});
    if (!config.add.empty()) asked.push_back({"add", " (several models)"});
    const std::vector<Material> materials = parse_materials(config.material);
    if (std::any_of(materials.begin(), materials.end(),
                    [](const Material& m) { return m.mirror > 0; }))
        asked.push_back({"material", " mirror"});
    return asked;
}

/// ConfigError of the first, which names the others, too.
void refuse_without_rays(const std::vector<Asked>& asked) {
    if (asked.empty()) return;
    std::string problem = asked[0].what;
    for (std::size_t i = 1; i < asked.size(); ++i)
        problem += (i + 1 < asked.size() ? ", " : " and ") + quoted_key(asked[i].key) +
                   asked[i].what;
    const char* const verb = asked.size() > 1 ? " need" : " needs";
    throw ConfigError({.key = asked[0].key,
                       .problem = problem + verb + " rays: " + quoted_key("mode") + " raytrace"});
}

}  // namespace

std::optional<double> ground_height(const RenderConfig& config) {
    if (config.ground_height == "auto") return std::nullopt;
    const auto numbers = parse_numbers(config.ground_height);
    if (numbers.size() != 1 || !std::isfinite(numbers[0]))
        throw ConfigError({.key = "ground_height",
                           .expected = "auto or a number",
                           .found = "'" + config.ground_height + "'",
                           .hint = did_you_mean(config.ground_height, {"auto"})});
    return numbers[0];
}

std::optional<Vec3f> ground_color(const RenderConfig& config) {
    if (config.ground_color == "shadow") return std::nullopt;
    const auto color = parse_color(config.ground_color);
    if (!color)
        throw ConfigError({.key = "ground_color",
                           .expected = "shadow or #rrggbb",
                           .found = "'" + config.ground_color + "'",
                           .hint = did_you_mean(config.ground_color, {"shadow"})});
    return color;
}

void check_tracing(const RenderConfig& config, const std::vector<std::string>& aovs) {
    if (!is_traced(config)) refuse_without_rays(asked_of_rays(config, aovs));
    refuse_unused(config, aovs);
    if (!config.add.empty() && contains(config.aov, "color"))
        throw ConfigError({.key = "aov", .problem = std::string(" color") + kOneModel});
    if (!config.add.empty() && shades_scan_colors(config.material))
        throw ConfigError({.key = "material", .problem = std::string(" color=scan") + kOneModel});
    check_lights(config.light);
    ground_height(config), ground_color(config);
    const std::size_t n_materials = parse_materials(config.material).size(),
                      n_models = 1 + config.add.size();
    if (n_materials > n_models)
        throw ConfigError({.key = "material",
                           .expected = fmt::format("at most one for each of {} model{}", n_models,
                                                   n_models == 1 ? "" : "s"),
                           .found = std::to_string(n_materials)});
}

}  // namespace slim
