#include "pipeline/job/view_shares.h"

#include "pipeline/config.h"
#include "pipeline/contains.h"
#include "pipeline/job/job_views.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// About 20 s of a core: starting a task costs a cluster seconds.
constexpr double kPixelsOfATask = 128e6;
/// Rays against the forward renderer.
constexpr double kRays = 8;
/// Pixels at edges drawn again, against one sample in each.
constexpr double kAntialias = 2;
constexpr int kLeastRows = 256;
constexpr int kMostShares = 256;

/// Pictures of each camera.
std::size_t n_aovs(const std::vector<std::string>& aovs) {
    if (!contains(aovs, "all")) return aovs.size();
    RenderConfig any;
    return fields_of(any).find("aov")->choices.size() - 2;  // but "all" itself and "lines"
}

double pixels_of(const RenderConfig& config, const std::vector<std::string>& aovs) {
    const PictureSize size = parse_size(config.size);
    const double samples =
        antialiases(config) ? kAntialias : config.supersample * config.supersample;
    return static_cast<double>(n_aovs(aovs)) * n_frames(config) * size.width * size.height *
           samples * (config.mode == "raytrace" ? kRays : 1);
}

bool is_part(const RenderConfig& config) {
    return !config.crop.empty() || !config.tile.empty() || config.frame > 0 || config.repeat > 1;
}

}  // namespace

ViewDivision division_of_view(const RenderConfig& config, const std::vector<std::string>& aovs,
                              int asked) {
    if (asked > 1) {
        RenderConfig share = config;
        share.share = fmt::format("1/{}", asked);
        share_of(share);
    }
    if (asked > 0) return {asked, asked > 1 ? fmt::format("shares = {}", asked) : ""};
    if (is_part(config)) return {};
    const double pixels = pixels_of(config, aovs), wanted = std::ceil(pixels / kPixelsOfATask);
    if (wanted < 2) return {};
    const std::string reason = fmt::format("{:.0f} million pixels at up to {:.0f} million a task",
                                           pixels / 1e6, kPixelsOfATask / 1e6);
    if (!is_film(config) && (!config.lines.empty() || contains(aovs, "lines")))
        return {1, reason +
                       ", but one picture with lines: each task would find those of all of it "
                       "(shares = n divides it)"};
    const int most =
        is_film(config) ? n_frames(config) : parse_size(config.size).height / kLeastRows;
    const int n =
        std::max(1, static_cast<int>(std::min<double>(wanted, std::min(most, kMostShares))));
    return {n, reason};
}

std::vector<JobShare> shares_of_view(const RenderConfig& config,
                                     const std::vector<std::string>& aovs, const fs::path& output,
                                     const std::string& name, int n) {
    std::vector<JobShare> shares;
    for (int i = 1; i <= n && n > 1; ++i) {
        const RenderShare share{i, n};
        JobShare task{fmt::format("--share={}/{}", i, n), share_target(output, share), {}};
        RenderConfig part = config;
        const auto add = [&](const fs::path& folder) {
            const auto files = view_pictures(folder, name, aovs, part);
            task.products.insert(task.products.end(), files.begin(), files.end());
        };
        if (is_film(config)) {
            const int frames = n_frames(config);
            for (int k = share_begin(frames, share); k < share_end(frames, share); ++k)
                part.frame = k + 1, add(output.parent_path());
        } else {
            add(share_folder(output, share));
            if (i > 1)  // the first writes the lines of all of the picture
                std::erase_if(task.products,
                              [](const fs::path& file) { return file.extension() == ".svg"; });
        }
        shares.push_back(std::move(task));
    }
    return shares;
}

}  // namespace slim
