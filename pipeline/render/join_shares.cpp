#include "pipeline/render/join_shares.h"

#include "pipeline/manifest.h"
#include "pipeline/render/render_aov.h"
#include "pipeline/render/render_files.h"
#include "pipeline/render/render_inputs.h"
#include "pipeline/render/render_view.h"
#include "pipeline/render/stitch_shares.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace slim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

fs::path named_of(const RenderConfig& config) {
    return plan_outputs(config, wanted_aovs(config)).named;
}

/// The recorded results of all shares. IncompleteError names those that are missing.
std::vector<Json> results_of_shares(const RenderConfig& config,
                                    const std::vector<std::string>& aovs, const ModelFile& model,
                                    const StageContext& context) {
    Reporter quiet;  // each would say that it is up to date
    const StageContext checking{quiet,         context.threads, false,
                                context.stage, context.config,  context.config_toml};
    const fs::path named = named_of(config);
    std::vector<Json> results;
    std::string missing;
    for (int i = 1; i <= config.join; ++i) {
        const RenderShare share{i, config.join};
        const RenderConfig own = config_of_share(config, share);
        Stamp stamp(checking, share_target(named, share));
        add_inputs(own, model, stamp);
        add_outputs(own, aovs, share, stamp);
        if (auto result = stamp.up_to_date())
            results.push_back(std::move(*result));
        else
            missing += fmt::format("{}{}/{}", missing.empty() ? "" : ", ", i, config.join);
    }
    if (!missing.empty())
        throw IncompleteError(
            fmt::format("{}: shares that are not drawn, or with other options or "
                        "of another model: {}: draw them with --share",
                        named.string(), missing));
    return results;
}

void add_counts(const Json& share, Json& sum) {
    for (const char* key : {"covered_pixels", "surfels_drawn", "loose_hidden", "nodes_visited",
                            "root_tests", "distance_tests", "unblended_pixels", "blocks_passed",
                            "surfels_cut_off", "light_rays", "clamped_values", "frames"})
        if (sum.contains(key))
            sum[key] = sum[key].get<std::int64_t>() + share.at(key).get<std::int64_t>();
    for (const char* key : {"model_bytes_read", "model_nodes_checked"})
        sum[key] = std::max(sum[key], share.at(key));
}

/// Counts of all shares, what was read of the model by the one that read most; times are the sum of
/// a picture's, the mean of a film's pictures.
Json joined_result(const RenderConfig& config, const std::vector<Json>& shares,
                   const std::vector<fs::path>& files) {
    Json result = shares[0];
    for (const char* key : {"up_to_date", "recorded", "whole_at_once"}) result.erase(key);
    double frame_ms = 0, seconds = 0;
    std::int64_t rendered_pixels = 0;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        if (i > 0) add_counts(shares[i], result);
        frame_ms += shares[i].at("frame_ms_median").get<double>() * shares[i].value("frames", 1);
        rendered_pixels += shares[i].at("rendered_pixels").get<std::int64_t>();
        seconds += shares[i].at("recorded").at("seconds").get<double>();
    }
    if (is_film(config) && result.contains("lines")) result["lines"] = shares.back().at("lines");
    if (!is_film(config)) {
        result["height"] = parse_size(config.size).height;
        result["rendered_pixels"] = rendered_pixels;
    }
    result["frame_ms_median"] = frame_ms / (is_film(config) ? result.value("frames", 1) : 1);
    result["shares"] = shares.size(), result["shares_seconds"] = seconds;
    result["files"] = Json::array();
    for (const fs::path& file : files) result["files"].push_back(file.string());
    return result;
}

/// Names without folders of what the shares have written.
std::set<fs::path> names_written(const std::vector<Json>& shares) {
    std::set<fs::path> names;
    for (const Json& share : shares)
        for (const Json& file : share.at("files"))
            names.insert(fs::path(file.get<std::string>()).filename());
    return names;
}

/// The numbered pictures, which lie where they belong, and the legends, which all shares have
/// written alike.
std::vector<fs::path> files_of_film(const OutputPlan& plan, int n_frames,
                                    const std::set<fs::path>& written) {
    std::vector<fs::path> files;
    const auto add = [&](const fs::path& file) {
        if (written.contains(file.filename())) files.push_back(file);
    };
    for (int k = 1; k <= n_frames; ++k) {
        const OutputPlan picture = n_frames > 1 ? plan.numbered(k) : plan;
        add(picture.lines_svg());
        for (const fs::path& png : picture.pngs) add(png);
        add(picture.exr);
    }
    for (const std::string& aov : plan.drawn) add(plan.legend(aov));
    return files;
}

}  // namespace

RenderConfig config_of_share(const RenderConfig& config, const RenderShare& share) {
    RenderConfig own = config;
    own.share.clear(), own.join = 0;
    if (is_film(config)) return own;
    const fs::path named = named_of(config), folder = share_folder(named, share);
    own.tile = fmt::format("{}/{}", share.number, share.of);
    // A folder names pictures otherwise than a file does.
    own.output = is_folder_output(config.output) ? folder.string() + "/"
                                                 : (folder / named.filename()).string();
    for (std::string* file : {&own.lines_ply, &own.lines_obj})
        if (!file->empty()) *file = (folder / fs::path(*file).filename()).string();
    return own;
}

Json join_shares(const RenderConfig& config, StageContext& context) {
    check_join(config);
    std::vector<std::string> aovs = wanted_aovs(config);
    const int n = check_request(config, aovs);
    const fs::path named = named_of(config);
    const ModelFile model = ModelFile::open_by_pages(config.model);
    keep_possible_aovs(config, model.header().degree, !model.colors().empty(), aovs);
    Stamp stamp(context, manifest_path(named));
    add_inputs(config, model, stamp);
    add_outputs(config, aovs, {}, stamp);
    if (auto result = stamp.up_to_date()) return *result;
    const std::vector<Json> shares = results_of_shares(config, aovs, model, context);
    const std::vector<fs::path> files =
        is_film(config) ? files_of_film(plan_outputs(config, aovs), n, names_written(shares))
                        : stitch_shares(config, aovs, names_written(shares),
                                        shares[0].at("whole_at_once"), context);
    Json result = joined_result(config, shares, files);
    if (result.at("covered_pixels") == 0)
        throw NumericalError(named.string() +
                             ": not one pixel of all shares meets the surface: see --camera");
    return stamp.commit(std::move(result), Outlasts::power_cut, files);
}

}  // namespace slim
