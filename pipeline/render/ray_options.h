#pragma once

#include "pipeline/render/render_config.h"
#include "slim/base/vec.h"

#include <optional>
#include <string>
#include <vector>

namespace slim {

inline bool is_traced(const RenderConfig& config) { return config.mode == "raytrace"; }

/// One sample a pixel, to which --antialias may add: --supersample 2 draws all samples, and by
/// brute force there are no others.
inline bool has_one_sample(const RenderConfig& config) {
    return config.supersample == 1 && config.mode != "brute";
}
/// Whether --antialias has anything to do.
inline bool antialiases(const RenderConfig& config) {
    return config.antialias && has_one_sample(config);
}

/// --ground-height; none is "auto". Throws ConfigError.
std::optional<double> ground_height(const RenderConfig& config);

/// --ground-color; none is "shadow". Throws ConfigError.
std::optional<Vec3f> ground_color(const RenderConfig& config);

/// Throws ConfigError for what only rays can do without --mode raytrace, for options that no
/// picture takes (refuse_unused), and for lights and materials that are none.
void check_tracing(const RenderConfig& config, const std::vector<std::string>& aovs);

}  // namespace slim
