#pragma once

#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_config.h"
#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/line_search.h"
#include "raytrace/svg_scale.h"
#include "slim/base/reporter.h"
#include "slim/model/sharp_edge.h"
#include "slim/model/surfel_tree.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// Throws ConfigError for files of lines whose names are not .ply and .obj.
void check_lines(const RenderConfig& config);

/// The kinds of lines to draw, in the order of drawing: contours last, on top. With the AOV "lines"
/// alone: contours, suggestive contours, crest lines if the model is cubic, and creases if it is
/// sharp (some model of the scene has sharp surfels). Kinds whose derivatives or sheets the model
/// does not have are left out with a warning; ConfigError if none is left.
std::vector<LineKind> wanted_lines(const RenderConfig& config, const std::vector<std::string>& aovs,
                                   const ModelHeader& model, bool sharp, Reporter& reporter);

/// What lines of one model need besides the frame.
struct LineModel {
    const ModelHeader* header;
    std::span<const SharpEdge> edges = {};
};

/// The search for the lines of a picture in frames of its own size, whole or band by band from the
/// top (LineSearch). Of several models contours and reflections are those of the picture; creases
/// are each model's, hidden by all; all else is found in each model by itself and measured by its
/// own diagonal and degree, so that what is drawn of it does not depend on what stands beside it.
class PictureLines {
public:
    PictureLines(std::span<const LineModel> models, std::span<const LineKind> kinds);

    /// Rows [begin, end) of the frame's part. (`frame` is changed and put back.)
    void add(int begin, int end, RenderedFrame& frame);
    /// In the order of the kinds.
    std::vector<FeatureLine> finish();

private:
    struct Search {
        std::size_t model;  ///< kAllModels, or the one that these lines are of
        double diagonal;
        int degree;
        std::span<const SharpEdge> edges;
        LineSearch lines;
    };
    static constexpr std::size_t kAllModels = SIZE_MAX;

    std::vector<LineKind> kinds_;
    std::vector<Search> searches_;
    float px_ = 1;  ///< line_pixel of the picture
};

/// The lines of a picture or a part of it.
struct DrawnLines {
    std::span<const FeatureLine> lines;
    std::span<const LineKind> kinds;
    PictureSize size;    ///< of the whole
    PixelWindow window;  ///< the part
};

/// A text to write and its file.
struct NamedText {
    std::filesystem::path path;
    std::string text;
};

/// The lines as SVG, and as PLY and OBJ if the configuration names such files.
std::vector<NamedText> line_files(const RenderConfig& config, const std::filesystem::path& svg,
                                  const SvgScale& scale, const Vec3d& origin,
                                  const DrawnLines& drawn);

/// {kind: {polylines, length (model units), length_px, strength}}, kinds by line_name. Strength is
/// the sum of the lines', of creases the mean over their length.
nlohmann::json lines_json(std::span<const FeatureLine> lines, std::span<const LineKind> kinds);

}  // namespace slim
