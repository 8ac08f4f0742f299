#include "pipeline/render/render_checks.h"

#include "pipeline/option_names.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_maps.h"
#include "pipeline/render/render_parts.h"
#include "pipeline/render/render_view.h"
#include "pipeline/shape_name.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace slim {
namespace {

void check_sun(const RenderConfig& config) {
    if (config.sun.size() != 2 || !(config.sun[1] >= 0 && config.sun[1] <= 90) ||
        !std::isfinite(config.sun[0]))
        throw ConfigError(
            {.key = "sun",
             .expected = "two angles in degrees, azimuth,altitude with an altitude from 0 to 90",
             .found = fmt::format("{}", fmt::join(config.sun, ","))});
}

void check_scale(const RenderConfig& config) {
    if (config.scale_bar && !config.ortho && config.ortho_width <= 0)
        throw ConfigError({.key = "scale_bar",
                           .problem = "a perspective picture has no one scale: draw it with " +
                                      quoted_key("ortho")});
}

void check_lines_of_film(const RenderConfig& config) {
    if (n_frames(config) <= 1) return;
    for (const auto& [key, file] :
         {std::pair{"lines_ply", &config.lines_ply}, {"lines_obj", &config.lines_obj}})
        if (!file->empty())
            throw ConfigError(
                {.key = key, .problem = " is for one picture, not for a turntable or path"});
}

}  // namespace

std::optional<double> contour_spacing(const RenderConfig& config) {
    if (config.contours == "auto") return std::nullopt;
    if (config.contours == "none") return 0.0;
    double value = 0;
    const char* const end = config.contours.data() + config.contours.size();
    const auto [rest, error] = std::from_chars(config.contours.data(), end, value);
    if (error == std::errc() && rest == end && value > 0 && std::isnormal(value)) return value;
    // Smaller ones are denormal: heights over them are infinite.
    throw ConfigError(
        {.key = "contours",
         .expected = "auto, none or a spacing above 0 in model units (2.3e-308 at least)",
         .found = "'" + config.contours + "'",
         .hint = did_you_mean(config.contours, {"auto", "none"})});
}

Vec3d shape_offset(const RenderConfig& config) {
    if (config.offset.empty()) return {};
    if (config.offset.size() != 3)
        throw ConfigError({.key = "offset",
                           .expected = "three numbers x,y,z",
                           .found = std::to_string(config.offset.size())});
    return {config.offset[0], config.offset[1], config.offset[2]};
}

void check_options(const RenderConfig& config, const std::vector<std::string>& aovs) {
    check_view_name(config.name);
    check_truth(config, aovs);
    check_ranges(config);
    contour_spacing(config);
    check_sun(config);
    check_tracing(config, aovs);
    parse_background(config.background, false);
    if (!config.truth_shape.empty()) shape_named(config.truth_shape, "truth_shape");
    shape_offset(config);
    check_lines_of_film(config);
    wanted_window(config, parse_size(config.size));
    check_scale(config);
}

}  // namespace slim
