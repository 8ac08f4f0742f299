#include "pipeline/render/render_check.h"

#include "pipeline/option_names.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/relief_options.h"
#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_maps.h"
#include "pipeline/render/render_parts.h"
#include "pipeline/render/render_view.h"
#include "pipeline/render/truth_shape.h"
#include "slim/base/error.h"

#include <string>
#include <utility>
#include <vector>

namespace slim {
namespace {

/// Any box will do: only cameras that are given by numbers can be wrong.
void check_cameras(const RenderConfig& config) {
    ModelHeader model;
    model.bounds = {{-1, -1, -1}, {1, 1, 1}};
    FilmCameras(config, model, {100, 100}, {});
}

void check_scale_bar(const RenderConfig& config) {
    if (config.scale_bar && !config.ortho && config.ortho_width <= 0)
        throw ConfigError(
            {.key = "scale_bar",
             .problem = "a perspective picture has no one scale: draw it with " +
                        quoted_key("ortho")});
}

/// Lines in space are those of one picture.
void check_film_lines(const RenderConfig& config) {
    if (n_frames(config) < 2) return;
    for (const auto& [key, file] : {std::pair{"lines_ply", &config.lines_ply},
                                    std::pair{"lines_obj", &config.lines_obj}})
        if (!file->empty())
            throw ConfigError(
                {.key = key, .problem = " is for one picture, not for a turntable or path"});
}

}  // namespace

void check_values(const RenderConfig& config) {
    parse_size(config.size);
    check_view_name(config.name);
    check_cameras(config);
    check_lights(config.light);
    parse_materials(config.material);
    parse_background(config.background, false);
    ground_height(config), ground_color(config);
    check_ranges(config);
    check_relief(config);
    check_truth(config);
}

void check_options(const RenderConfig& config) {
    check_values(config);
    const std::vector<std::string> aovs = wanted_aovs(config);
    check_tracing(config, aovs);
    check_scale_bar(config);
    check_film_lines(config);
    wanted_window(config, parse_size(config.size));
}

}  // namespace slim
