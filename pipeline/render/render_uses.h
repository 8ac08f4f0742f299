#pragma once

#include "pipeline/render/render_config.h"
#include "slim/base/error.h"

#include <span>
#include <string>
#include <vector>

namespace slim {

/// The AOVs that "all" stands for: every one that a model alone can give.
const std::vector<std::string>& aovs_of_all();

/// Whether the picture of some of these AOVs ("all" for all of them) has a legend or a key.
bool has_legend(const RenderConfig& config, const std::vector<std::string>& aovs);

/// What panels the pictures of some AOVs have, where they have any: none, keys of directions or
/// contour lines alone, or the legend of a map.
enum class Legends { none, directions, contours, both_keys, maps };
Legends legends_of(const RenderConfig& config, const std::vector<std::string>& aovs);

/// Whether some camera of the run frames the model by itself,
/// so that it can leave room for a legend.
bool frames_by_name(const RenderConfig& config);

/// An option of slim render that only some pictures take.
struct OptionUse {
    const char* key;    ///< in the order in which they depend on one another: ao before ao_samples
    const char* what;   ///< "the aov hillshade"
    const char* remedy; ///< ": --ao or --aov ao", or empty
    bool (*used)(const RenderConfig& config, const std::vector<std::string>& aovs);
};
std::span<const OptionUse> option_uses();

/// ConfigError for an option that is given (is not as by default) and that none of the pictures
/// takes: none is ignored without a word.
void refuse_unused(const RenderConfig& config, const std::vector<std::string>& aovs);

/// "ao_samples is for ambient occlusion, which is not asked for: --ao or --aov ao".
ConfigError unused_option(const OptionUse& use, const Fault& place = {},
                          const std::string& hint = {});

}  // namespace slim
