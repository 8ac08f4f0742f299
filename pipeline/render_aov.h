#pragma once

#include "pipeline/render_config.h"
#include "pipeline/render_view.h"
#include "raytrace/frame.h"
#include "raytrace/legend.h"
#include "raytrace/lines/feature_line.h"
#include "raytrace/picture.h"
#include "raytrace/trace/trace_renderer.h"
#include "slim/base/bbox.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// The AOVs to draw, without doubles, "all" replaced by every one the model alone can give. Throws
/// ConfigError for truth_distance without a --truth-shape, or a shape without it.
std::vector<std::string> wanted_aovs(const RenderConfig& config);

/// What the renderer must deliver for these AOVs, and no more.
Channels channels_of(const std::vector<std::string>& aovs, bool light_maps);

/// AOVs whose pictures must not be averaged (ids, levels), or cost too much at twice the size.
bool is_filterable(const std::string& aov);

/// One rendered frame and what derives from it.
struct RenderedFrame {
    PictureSize size;
    ShadeView view;
    GBuffer buffer;
    std::vector<float> truth_distance;  ///< empty unless asked for; model units, 0 without a hit
    TracedPlanes traced;                ///< of a frame drawn by rays
    std::vector<float> open;            ///< ambient openness, 0 to 1; empty unless asked for
    TraceCounts light_counts;           ///< rays for light
    Picture shaded;                     ///< at the picture's size; empty unless asked for
    std::vector<FeatureLine> lines;     ///< those asked for, in the order of drawing
};

/// Signed distance of every hit to the shape of config.truth_shape (its origin at config.offset in
/// the world), positive outside. Parallel over pixels. Throws ConfigError for an unknown shape or a
/// bad offset. Cost: about five evaluations of the shape per hit.
std::vector<float> truth_distances(const RenderConfig& config, const Vec3d& model_origin,
                                   const GBuffer& buffer);

/// A picture of one AOV, over transparent.
struct AovPicture {
    Picture picture;
    std::optional<Legend> legend;           ///< of a map
    /// what the legend points to, if made for this picture
    std::shared_ptr<const ColorMap> own_map;
};

/// Draws an AOV; a frame larger than `size` is averaged.
AovPicture draw_aov(const RenderConfig& config, const std::string& aov, const RenderedFrame& frame,
                    const Bbox& bounds, const PictureSize& size);

/// Share of the picture's width that the widest legend burned into these AOVs will take at the
/// right; 0 without any. The numbers on it are not known yet: assumed to be of a usual length.
double legend_room(const RenderConfig& config, const std::vector<std::string>& aovs,
                   const PictureSize& size);

}  // namespace slim
