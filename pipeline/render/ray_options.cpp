#include "pipeline/render/ray_options.h"

#include "pipeline/contains.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_uses.h"
#include "pipeline/render/render_view.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {
namespace {

/// What only rays can do.
void require_rays(const RenderConfig& config, const std::vector<std::string>& aovs) {
    const auto require = [](bool asked, const char* what) {
        if (asked) throw ConfigError(fmt::format("{} needs rays: --mode raytrace", what));
    };
    require(contains(aovs, "ao"), "aov ao");
    require(config.ao, "ao");
    require(config.ground, "ground");
    require(!config.add.empty(), "add (several models)");
    for (const Material& m : parse_materials(config.material))
        require(m.mirror > 0, "material mirror");
}

}  // namespace

std::optional<double> ground_height(const RenderConfig& config) {
    if (config.ground_height == "auto") return std::nullopt;
    const auto numbers = parse_numbers(config.ground_height);
    if (numbers.size() != 1 || !std::isfinite(numbers[0]))
        throw ConfigError("ground_height: expected auto or a number, found \"" +
                          config.ground_height + "\"");
    return numbers[0];
}

std::optional<Vec3f> ground_color(const RenderConfig& config) {
    if (config.ground_color == "shadow") return std::nullopt;
    const auto color = parse_color(config.ground_color);
    if (!color)
        throw ConfigError("ground_color: expected shadow or #rrggbb, found \"" +
                          config.ground_color + "\"");
    return color;
}

void check_tracing(const RenderConfig& config, const std::vector<std::string>& aovs) {
    if (!is_traced(config)) require_rays(config, aovs);
    refuse_unused(config, aovs);
    if (!config.add.empty() && contains(config.aov, "color"))
        throw ConfigError("aov color shows the colours of one model: leave out add");
    if (!config.add.empty() && shades_scan_colors(config.material))
        throw ConfigError("material color=scan shows the colours of one model: leave out add");
    check_lights(config.light);
    ground_height(config), ground_color(config);
    const std::size_t n_materials = parse_materials(config.material).size(),
                      n_models = 1 + config.add.size();
    if (n_materials > n_models)
        throw ConfigError(
            fmt::format("material: expected at most one for each of {} model{}, found {}", n_models,
                        n_models == 1 ? "" : "s", n_materials));
}

}  // namespace slim
