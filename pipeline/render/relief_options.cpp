#include "pipeline/render/relief_options.h"

#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace slim {

std::optional<double> fixed_spacing(const RenderConfig& config) {
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

void check_relief(const RenderConfig& config) {
    fixed_spacing(config);
    if (config.sun.size() != 2 || !(config.sun[1] >= 0 && config.sun[1] <= 90) ||
        !std::isfinite(config.sun[0]))
        throw ConfigError(
            {.key = "sun",
             .expected = "two angles in degrees, azimuth,altitude with an altitude from 0 to 90",
             .found = fmt::format("{}", fmt::join(config.sun, ","))});
}

}  // namespace slim
