#pragma once

#include "pipeline/job/job.h"
#include "pipeline/render/render_config.h"

#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// Among how many tasks plans divide a view, and why.
struct ViewDivision {
    int shares = 1;
    std::string reason;  ///< "300 million pixels at up to 128 million a task"; empty without one
};

/// `asked` tasks; if that is 0, as many as leave each at most 128 million pixels to draw: those of
/// all pictures of the view, twice as many with antialiasing, four times with supersampling, eight
/// times with rays. Films are divided by pictures, single pictures by rows (256 at least); not by
/// itself one with lines, as each task would find those of all the picture, nor part of a picture
/// or film. ConfigError if what is asked for cannot be divided.
ViewDivision division_of_view(const RenderConfig& config, const std::vector<std::string>& aovs,
                              int asked);

/// The tasks of a view whose step writes `output` (JobStep::output) and is called `name`.
std::vector<JobShare> shares_of_view(const RenderConfig& config,
                                     const std::vector<std::string>& aovs,
                                     const std::filesystem::path& output, const std::string& name,
                                     int n);

}  // namespace slim
