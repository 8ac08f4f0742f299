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

/// The same reasons as one line names them, "left out: curvature, rays (why: HOW)"; empty without
/// any. What the points decided the build has said, and which pictures nobody asked for is known.
std::string left_out_in_a_line(std::span<const std::string> reasons, const std::string& how);

/// What views ask for and models of this [fit] cannot give: lines of which a picture then shows
/// less, what "all" passes over. A line each, with the views and the remedy; none of views that are
/// refused.
struct MissingInViews {
    std::vector<std::string> certain;
    std::vector<std::string> uncertain;  ///< may be there: the points decide
};
MissingInViews missing_in_views(std::span<const AskedView> views, const BuildStages& stages);

}  // namespace slim
