#pragma once

#include "pipeline/render/render_config.h"
#include "raytrace/environment.h"
#include "raytrace/hillshade.h"
#include "raytrace/matcap.h"
#include "raytrace/picture.h"
#include "raytrace/shade.h"
#include "slim/color/color_blend.h"
#include "slim/model/surfel_tree.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace slim {

struct RenderedFrame;

/// AOVs that are pictures of light, not of numbers, besides "shaded": environment, matcap,
/// reflection, hillshade, color (the scan's own).
bool is_shading(const std::string& aov);
/// These and "shaded".
bool is_color(const std::string& aov);

/// What such pictures are made of; only what the AOVs need is loaded.
struct ShadingInputs {
    std::optional<Environment> environment;
    std::optional<Matcap> matcap;
    std::optional<ColorBlend> colors;
    Relief relief;
};

/// throws IoError, FormatError for the file of an environment or matcap.
/// The spacing of "auto" contours is not known yet: 0 until choose_contours.
ShadingInputs load_shadings(const RenderConfig& config, const std::vector<std::string>& aovs,
                            const ModelHeader& model);

/// Some rows of a frame as that AOV shows them, over transparent. A relief leaves gaps for heights
/// that will be written (pixels of a picture whose pixels are `factor` of the frame's wide).
Picture paint_shading(const std::string& aov, const ShadingInputs& inputs,
                      const RenderedFrame& frame, const RowRange& rows,
                      std::span<const HeightLabel> heights = {}, int factor = 1);

/// Puts the environment behind a picture whose first pixel is (x0, y0) of the view.
void composite_over_environment(const Environment& environment, const PixelView& view, int x0,
                                int y0, Picture& picture);

}  // namespace slim
