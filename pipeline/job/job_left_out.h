#pragma once

#include "pipeline/job/job.h"
#include "pipeline/render/render_config.h"

#include <span>
#include <string>
#include <vector>

namespace slim {

/// A view as its table and [render] say it.
struct AskedView {
    std::string name;
    std::vector<std::string> aovs;
    RenderConfig render;
    bool refused = false;  ///< no model of [fit] has what it shows
};

/// What no view of a job asks for, so that it is neither computed nor read: by the channels that
/// the renderer is asked for (channels_of, line_channels), a line each with the reason.
std::vector<std::string> left_out_of_views(std::span<const AskedView> views,
                                           const BuildStages& stages);

/// What views ask for and models of this [fit] cannot give: lines of which a picture then shows
/// less, what "all" passes over. A line each, with the remedy; none of views that are refused.
struct MissingInViews {
    std::vector<std::string> certain;
    std::vector<std::string> uncertain;  ///< may be there: the points decide
};
MissingInViews missing_in_views(std::span<const AskedView> views, const BuildStages& stages);

}  // namespace slim
