#include "pipeline/render/ray_options.h"

#include "pipeline/contains.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_uses.h"
#include "pipeline/render/render_view.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {
namespace {

constexpr const char* kOneModel = " shows the colours of one model: leave out --add";

/// What only rays can do.
void require_rays(const RenderConfig& config, const std::vector<std::string>& aovs) {
    const auto require = [](bool asked, const char* key, const std::string& what = {}) {
        if (asked)
            throw ConfigError({.key = key, .problem = what + " needs rays: --mode raytrace"});
    };
    require(contains(aovs, "ao"), "aov", " ao");
    require(config.ao, "ao");
    require(config.ground, "ground");
    require(!config.add.empty(), "add", " (several models)");
    for (const Material& m : parse_materials(config.material))
        require(m.mirror > 0, "material", " mirror");
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
    if (!is_traced(config)) require_rays(config, aovs);
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
