#pragma once

#include "formats/image_io.h"
#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_config.h"
#include "pipeline/render/render_lines.h"
#include "raytrace/camera.h"
#include "raytrace/svg_scale.h"
#include "slim/model/surfel_tree.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// Which files a run writes: fixed before anything is drawn.
///
///     -o x.png, one AOV     x.png
///     -o x.png, several     x.<aov>.png
///     -o x.exr              x.exr with all channels, and x.png, a preview of the first AOV
///     -o x.PNG, x.EXR       the same, their extension as given
///     several frames        each of these numbered: x_0001.png, x.<aov>_0001.png
///     -o folder, folder/    folder/<view>.<aov>.png, or with --format exr folder/<view>.exr and
///                           .png
/// Feature lines are beside them as x.lines.svg (also of x.shaded.png, if that is the one AOV).
/// Contour lines of a relief are beside it as x.contours.svg (also of x.hillshade.png); of films
/// there are none.
/// A map with a legend has it as x.<aov>.legend.svg too (x.mean.legend.svg also of x.mean.png).
struct OutputPlan {
    std::filesystem::path exr;                ///< empty: none
    std::vector<std::filesystem::path> pngs;  ///< one per drawn AOV: all, or the preview's
    std::vector<std::string> drawn;           ///< those AOVs
    /// Those whose legends cameras leave room for: of data files, which are to overlay, none.
    std::vector<std::string> framed() const {
        return exr.empty() ? drawn : std::vector<std::string>();
    }
    std::filesystem::path stem;               ///< without extension: legends
    std::string number = {};                  ///< "_0001" of a film's picture
    std::filesystem::path named;              ///< with it, as given: the manifest's name
    std::filesystem::path legend(const std::string& aov) const;
    std::filesystem::path lines_svg() const;
    std::filesystem::path contours_svg() const;
    /// The same for picture k of a film: x_0001.png, x.mean_0001.png, x_0001.exr, x_0001.lines.svg.
    OutputPlan numbered(int k) const;

private:
    std::string drawing_stem() const;
};

/// Command lines that make films of numbered pictures, one for each drawn AOV.
std::vector<std::string> film_commands(const OutputPlan& plan);

/// Throws ConfigError for an extension that is neither, or that contradicts --format.
OutputPlan plan_outputs(const RenderConfig& config, const std::vector<std::string>& aovs);

/// Makes the output's folder. Throws IoError naming it.
void make_folder(const OutputPlan& plan);

/// A picture of light and the AOV it is of, in the order of the AOVs.
struct ColorPlane {
    std::string aov;
    Picture picture;  ///< over transparent
};

/// The EXR's channels for these AOVs and kinds of lines (their strength), names as in CONVENTIONS
/// 1.1: at most four a layer, so that the kinds it does not name are in a layer of their own,
/// `marks`. The first picture of light is R G B A without a layer. `planes` keeps what had to be
/// rearranged and must outlive the result.
std::vector<ExrChannel> exr_channels(const std::vector<std::string>& aovs,
                                     const RenderedFrame& frame, std::span<const ColorPlane> colors,
                                     const DrawnLines& lines,
                                     std::vector<std::vector<float>>& planes);

/// Text attributes of every picture: program, configuration, camera, origin, unit. Times and paths
/// stay out; DateTime is there only if SOURCE_DATE_EPOCH gives it. Orthographic pictures of a unit
/// that is known (mm, cm, dm, m, km, in, ft) say how many pixels a metre of the model has, so that
/// they print at 1 : 1, if that is 100 or more: a whole number is then within half a percent of it.
ImageMetadata make_metadata(const RenderConfig& config, const std::string& canonical_config,
                            const std::string& model_hash, const ModelHeader& model,
                            const Camera& camera, const PictureSize& size);

/// Of the drawings beside a picture: as large as the model where the picture says how it prints at
/// 1 : 1, else as on a screen.
SvgScale svg_scale(const RenderConfig& config, const Camera& camera, const PictureSize& size);

/// worldToCamera (right-handed, looking along -Z), worldToNDC ([0, 1]^2, origin top left, depth
/// unscaled) and worldToScreen (the same in [-1, 1]^2, y upwards) in row-vector form, for the local
/// frame that P lies in.
ImageMatrices make_matrices(const Camera& camera, const PictureSize& size);

}  // namespace slim
