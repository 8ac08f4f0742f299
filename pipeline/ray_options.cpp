#include "pipeline/ray_options.h"

#include "pipeline/contains.h"
#include "pipeline/render_lights.h"
#include "pipeline/render_view.h"
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

/// Options of what is not asked for.
void refuse_idle(const RenderConfig& config, const std::vector<std::string>& aovs) {
    const RenderConfig usual;
    const bool open = config.ao || contains(aovs, "ao");
    if (!open && (config.ao_distance != usual.ao_distance || config.ao_samples != usual.ao_samples))
        throw ConfigError(
            "ao_distance and ao_samples are for ambient occlusion, which is not asked for: --ao or "
            "--aov ao");
    if (!config.ground &&
        (config.ground_height != usual.ground_height || config.ground_color != usual.ground_color))
        throw ConfigError(
            "ground_height and ground_color are for the ground, which is not asked for: --ground");
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
    refuse_idle(config, aovs);
    if (!config.add.empty() && contains(config.aov, "color"))
        throw ConfigError("aov color shows the colours of one model: leave out add");
    check_lights(config.light);
    ground_height(config), ground_color(config);
    const std::size_t n_materials = parse_materials(config.material).size(),
                      n_models = 1 + config.add.size();
    if (n_materials > n_models)
        throw ConfigError(
            fmt::format("material: expected at most one for each of {} model{}, found {}", n_models,
                        n_models == 1 ? "" : "s", n_materials));
}

std::vector<std::string> idle_lighting(const RenderConfig& config,
                                       const std::vector<std::string>& aovs) {
    std::vector<std::string> idle;
    if (contains(aovs, "shaded")) return idle;
    const RenderConfig usual;
    if (config.ao) idle.push_back("ao");
    if (config.ground && !contains(aovs, "ao")) idle.push_back("ground");
    if (config.light != usual.light) idle.push_back("light");
    if (config.material != usual.material) idle.push_back("material");
    if (config.ambient != usual.ambient) idle.push_back("ambient");
    return idle;
}

}  // namespace slim
