#include "pipeline/render/truth_shape.h"

#include "pipeline/shape_name.h"
#include "slim/base/error.h"

#include <string>

namespace slim {

Vec3d shape_offset(const RenderConfig& config) {
    if (config.offset.empty()) return {};
    if (config.offset.size() != 3)
        throw ConfigError({.key = "offset",
                           .expected = "three numbers x,y,z",
                           .found = std::to_string(config.offset.size())});
    return {config.offset[0], config.offset[1], config.offset[2]};
}

void check_truth(const RenderConfig& config) {
    if (!config.truth_shape.empty()) shape_named(config.truth_shape, "truth_shape");
    shape_offset(config);
}

}  // namespace slim
