#pragma once

#include "pipeline/render_aov.h"
#include "pipeline/render_config.h"
#include "raytrace/camera.h"
#include "raytrace/lines/feature_line.h"
#include "slim/base/reporter.h"
#include "slim/model/sharp_edge.h"
#include "slim/model/surfel_tree.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// Throws ConfigError for files of lines that nobody asks for, or whose names are not .ply and .obj.
void check_lines(const RenderConfig& config, const std::vector<std::string>& aovs);

/// The kinds of lines to draw, in the order of drawing: contours last, on top. With the AOV "lines"
/// alone: contours, suggestive contours, crest lines if the model is cubic, and creases if it is sharp (some
/// model of the scene has sharp surfels). Kinds whose derivatives or sheets the model does not have are left
/// out with a warning; ConfigError if none is left.
std::vector<LineKind> wanted_lines(const RenderConfig& config, const std::vector<std::string>& aovs,
                                   const ModelHeader& model, bool sharp, Reporter& reporter);

/// What lines of one model need besides the frame.
struct LineModel {
    const ModelHeader* header;
    std::span<const SharpEdge> edges = {};
};

/// The lines of a rendered frame of the picture's own size. Of several models contours and reflections are
/// those of the picture; creases are each model's, hidden by all; all else is found in each model by itself
/// and measured by its own diagonal and degree, so that what is drawn of it does not depend on what stands
/// beside it. (`frame` is changed and put back.)
std::vector<FeatureLine> find_lines(const Camera& camera, std::span<const LineModel> models,
                                    std::span<const LineKind> kinds, RenderedFrame& frame);

/// Writes svg, and PLY and OBJ if the configuration names them; returns what was written.
std::vector<std::filesystem::path> write_lines(const RenderConfig& config,
                                               const std::filesystem::path& svg,
                                               const PictureSize& size, const Vec3d& origin,
                                               std::span<const FeatureLine> lines,
                                               std::span<const LineKind> kinds);

/// {kind: {polylines, length (model units), length_px, strength}}, kinds by line_name. Strength is the sum of
/// the lines', of creases the mean over their length.
nlohmann::json lines_json(std::span<const FeatureLine> lines, std::span<const LineKind> kinds);

}  // namespace slim
