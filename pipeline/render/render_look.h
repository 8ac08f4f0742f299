#pragma once

#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_config.h"
#include "pipeline/render/render_maps.h"
#include "raytrace/height_label.h"
#include "raytrace/hillshade.h"
#include "raytrace/key.h"
#include "raytrace/legend.h"
#include "raytrace/legend_room.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// What is decided for a picture as a whole before any part of it is painted.
struct AovLook {
    std::optional<Legend> legend;  ///< of a map
    std::optional<Key> key;        ///< of colours that are no scale
    /// what the legend points to, if made for this picture
    std::shared_ptr<const ColorMap> own_map;
    LegendPlace place = LegendPlace::right;
    bool words_fit = true;  ///< legend or key has room beside the scale bar
    LegendPlace bar_place = LegendPlace::left_bottom;  ///< of the scale bar
    std::vector<HeightLabel> heights = {};  ///< of a relief's contour lines

    bool on_white() const { return legend.has_value() || key.has_value(); }
};

/// Range, legend and its place by a reference frame: the view at no more than 1000 pixels on its
/// longer side, so that all parts of a picture and all frames of a film agree.
/// `wider`, if given, is held by the range of a map.
AovLook look_of(const RenderConfig& config, const std::string& aov, const RenderedFrame& reference,
                const MapScale& scale, const ContourLevels& contours,
                const ValueRange* wider = nullptr);

/// A map's range by a reference frame alone.
ValueRange range_of(const RenderConfig& config, const std::string& aov,
                    const RenderedFrame& reference, const MapScale& scale);

/// Whether look_of needs a reference frame for this AOV at all. Of a picture that is nearer than
/// what a named camera frames every one does for the scale bar.
bool needs_reference(const RenderConfig& config, const std::string& aov);

/// What legends take at the right, below or in a corner; nothing where none of the AOVs drawn
/// (OutputPlan::framed) has one (unless --legend-room wants it) or the picture is too
/// small for all that they have. Beside a map, and with --legend-room, it is what the largest of
/// all AOVs would take, the same whatever else is asked for, so that pictures of one camera
/// overlay; keys alone (of contour lines and directions) take what they need. The numbers are not
/// known yet: assumed to be of a usual length.
LegendRoom legend_room(const RenderConfig& config, const std::vector<std::string>& drawn,
                   const PictureSize& size);

}  // namespace slim
