#pragma once

#include "pipeline/render/render_config.h"
#include "raytrace/camera.h"
#include "raytrace/legend_room.h"
#include "raytrace/shade.h"
#include "slim/model/surfel_tree.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

struct PictureSize {
    int width = 0, height = 0;
};

/// "1600x1200"; each side 1 to 32768. Throws ConfigError.
PictureSize parse_size(const std::string& text);

/// Numbers between commas; empty if one of them is none.
std::vector<double> parse_numbers(const std::string& text);

/// "#rrggbb" or "#rgb" as linear Rec.709.
std::optional<Vec3f> parse_color(std::string_view text);

/// --up.
UpAxis up_axis(const RenderConfig& config);

/// The camera that the configuration describes, in the model's local frame. Named cameras frame
/// what is drawn (header.hull, else its bounds), clear of the room for legends unless --ortho-width
/// fixes the scale, and zoom about their middle; numbers are world
/// coordinates (origin + local). Throws ConfigError.
Camera make_camera(const RenderConfig& config, const ModelHeader& model, const PictureSize& size,
                   const LegendRoom& room);

/// How many pictures: of --turntable or --frames, 1 without either. Throws ConfigError where they,
/// --path and --frame do not fit together.
int n_frames(const RenderConfig& config);

/// The camera of picture `frame` (from 0) of a turntable or path; of the one picture make_camera's.
Camera frame_camera(const RenderConfig& config, const ModelHeader& model, const PictureSize& size,
                    const LegendRoom& room, int frame);

/// The view's name in file names: config.name, else the named camera, else "view".
std::string view_name(const RenderConfig& config);

/// Whether an output is a folder, that is or is meant.
bool is_folder_output(const std::filesystem::path& output);

/// The keyframes of --path, "iso zoom 2" each; a single empty one without it.
std::vector<std::string> keyframes_of(const RenderConfig& config);

/// The cameras of the run, as named or in numbers: --camera, or those of --path's keyframes.
std::vector<std::string> cameras_of(const RenderConfig& config);

/// Throws ConfigError on a name that would lead out of the output's folder.
void check_view_name(const std::string& name);

/// Camera in words and world coordinates, all digits: for errors and metadata.
std::string describe(const Camera& camera, const Vec3d& origin);

/// The camera as shading sees it, for planes that begin at (first_x, first_y) of a picture of that
/// size.
ShadeView shade_view(const Camera& camera, const PictureSize& size, int first_x = 0,
                     int first_y = 0);

/// --background; "auto" is a grey gradient behind a rendered object (shaded, normal) and white
/// behind a map. Throws ConfigError.
Background parse_background(const std::string& text, bool is_map);

}  // namespace slim
