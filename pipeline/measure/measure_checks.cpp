#include "formats/extension.h"
#include "pipeline/measure/measure_stage.h"
#include "slim/base/error.h"

namespace slim {

void check_per_point(const MeasureConfig& config) {
    if (!config.per_point.empty() && lower_extension(config.per_point) != ".ply")
        throw ConfigError({.file = config.per_point,
                           .problem = "the figures of points are a PLY",
                           .expected = "a name ending in .ply"});
}

void check_measure_options(const MeasureConfig& config) {
    check_per_point(config);
    if (!config.two_way && config.samples != MeasureConfig{}.samples)
        throw ConfigError(
            {.key = "samples",
             .problem = " are those of the model's surface, which is not measured",
             .expected = "--two-way with it"});
}

}  // namespace slim
