#pragma once

#include "pipeline/render/render_config.h"
#include "raytrace/frame.h"

#include <cstdint>
#include <string>
#include <vector>

namespace slim {

/// Mean, Gauss and principal curvatures.
bool is_curvature(const std::string& aov);
/// Derivatives of curvature.
bool is_third_order(const std::string& aov);

/// The AOVs to draw, without doubles, "all" replaced by every one a model alone can give. Throws
/// ConfigError for truth_distance without a --truth-shape.
std::vector<std::string> wanted_aovs(const RenderConfig& config);

/// ConfigError for truth_distance among them without a --truth-shape.
void check_truth(const RenderConfig& config, const std::vector<std::string>& aovs);

/// AOVs with "all" written out and without what a model of that degree, with or without colours,
/// cannot give.
std::vector<std::string> possible_aovs(const std::vector<std::string>& asked, int degree,
                                       bool has_colors);

/// Some AOVs that "all" passes over, and why.
struct LeftOut {
    std::string aovs;  ///< "e1, e2"
    std::string reason;
};
/// How a reader says what he wants: options of a command line, keys of a job.
enum class SaidBy : std::uint8_t { options, keys };
/// What "all", if it is among those asked for, passes over of the AOVs that are not asked for by
/// name.
std::vector<LeftOut> left_out_of_all(const std::vector<std::string>& asked, int degree,
                                     bool has_colors, SaidBy said_by);

/// Takes out what this model cannot give: derivatives of curvature unless it is cubic, colour
/// unless it has any. ConfigError, naming the remedy, if one was asked for by name.
void keep_possible_aovs(const RenderConfig& config, int degree, bool has_colors,
                        std::vector<std::string>& aovs);

/// What the renderer must deliver for these AOVs, and no more.
Channels channels_of(const std::vector<std::string>& aovs, bool light_maps);

/// AOVs whose pictures must not be averaged (ids, levels), or cost too much at twice the size.
bool is_filterable(const std::string& aov);

}  // namespace slim
