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

/// The view's name in file names: config.name, else the named camera, else "view".
std::string view_name(const RenderConfig& config);

/// Whether an output is a folder, that is or is meant.
bool is_folder_output(const std::filesystem::path& output);

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
