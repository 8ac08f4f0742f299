#include "pipeline/render/render_stage.h"

#include "formats/image_io.h"
#include "formats/model_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/peak_memory.h"
#include "pipeline/render/join_shares.h"
#include "pipeline/render/model_reads.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_cameras.h"
#include "pipeline/render/render_edges.h"
#include "pipeline/render/render_film.h"
#include "pipeline/render/render_frames.h"
#include "pipeline/render/render_inputs.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_reference.h"
#include "pipeline/render/render_summary.h"
#include "pipeline/render/render_trace.h"
#include "pipeline/render/render_views.h"
#include "pipeline/render/truth_shape.h"
#include "raytrace/font.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace slim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Whether a picture takes all of the model: rays and the blend of colours go through trees
/// of all its leaves.
bool takes_all_leaves(const RenderConfig& config, const std::vector<std::string>& aovs) {
    return config.mode != "forward" || takes_colors(config, aovs);
}

Json ranges_json(const RenderJob& job) {
    Json ranges = Json::object();
    for (const std::string& aov : job.plan.drawn)
        if (const auto& legend = job.looks.at(aov).legend)
            ranges[aov] = Json::array({legend->range.lo, legend->range.hi});
    return ranges;
}

/// Spacing as asked for, the heights that it was held against, and how many lines lie there.
Json contours_json(const ContourLevels& c) {
    return {{"spacing", c.spacing},
            {"heights", {c.low, c.high}},
            {"lines", c.lines},
            {"heavy", c.heavy}};
}

Json make_result(const RenderJob& job, const RenderOutcome& outcome) {
    Json files = Json::array();
    for (const auto& file : outcome.files) files.push_back(file.string());
    const RenderStats& s = outcome.stats;
    Json result = {{"files", files},
                   {"width", job.window.width},
                   {"height", job.window.height},
                   {"rendered_pixels", static_cast<std::int64_t>(job.window.width) *
                                           job.window.height * outcome.factor * outcome.factor},
                   {"covered_pixels", s.covered_pixels},
                   {"surfels_drawn", s.surfels_drawn},
                   {"loose_hidden", s.loose_hidden},
                   {"nodes", job.tree.n_nodes()},
                   {"nodes_visited", s.nodes_visited},
                   {"root_tests", s.root_tests},
                   {"distance_tests", s.distance_tests},
                   {"blocks_passed", s.blocks_passed},
                   {"surfels_cut_off", s.surfels_cut_off},
                   {"unblended_pixels", s.unblended_pixels},
                   {"plane_bytes", outcome.plane_bytes},
                   {"frame_ms_median", outcome.frame_ms / outcome.frames},
                   {"ranges", ranges_json(job)}};
    if (job.wants("hillshade") && job.config.contours != "none")
        result["contours"] = contours_json(job.contours);
    if (job.antialiases()) result["antialiased_pixels"] = outcome.smoothed_pixels;
    if (job.traced) {
        result["light_rays"] = outcome.light_rays;
        result["scene_ms"] = job.traced->build_ms();
        if (job.config.ground) result["ground_height"] = ground_level(job.config, *job.traced);
    }
    if (job.wants("truth_distance")) result["truth_unknown_pixels"] = outcome.truth_unknown;
    if (!job.plan.exr.empty()) result["clamped_values"] = outcome.clamped;
    if (job.share.of > 0) result["whole_at_once"] = outcome.whole_at_once;
    if (!outcome.lines.is_null()) result["lines"] = outcome.lines;
    if (job.n_frames > 1) {
        result["frames"] = outcome.frames;
        result["film_commands"] = film_commands(job.plan);
    }
    if (job.camera.orthographic) result["pixel_size"] = job.camera.width / job.size.width;
    return result;
}

void require_surfels(const RenderConfig& config, const SurfelTree& tree) {
    if (tree.header().n_leaves == 0)
        throw DataError(config.model + ": a model without surfels cannot be drawn");
}

/// Curvature comes from the surfels' second derivatives, which planes do not have.
void warn_of_flat_surfels(const RenderJob& job, Reporter& reporter) {
    if (job.tree.header().degree > 1) return;
    for (const char* aov : {"mean", "gauss", "k1", "k2", "dir1", "dir2"})
        if (job.wants(aov))
            return reporter.warn(
                fmt::format("{}: a model of degree 1 is flat within each surfel, so that its "
                            "curvature says little: build it with --degree 2",
                            job.config.model));
}

/// A named camera frames all models: what is a thousandth of another is less than a pixel or two,
/// mostly for another unit.
void warn_of_sizes(const RenderJob& job, Reporter& reporter) {
    constexpr double kUnseen = 1000;
    const RenderConfig& c = job.config;
    if (c.add.empty() || !c.path.empty() || !is_camera_name(c.camera)) return;
    const auto models = job.models();
    const auto [small, large] = std::minmax_element(
        models.begin(), models.end(),
        [](auto* a, auto* b) { return a->bounds.diagonal() < b->bounds.diagonal(); });
    const double least = (*small)->bounds.diagonal(), factor = (*large)->bounds.diagonal() / least;
    if (!(least > 0 && factor > kUnseen)) return;  // a single surfel's box is a point, of no unit
    const auto name = [&](auto model) {
        const auto i = static_cast<std::size_t>(model - models.begin());
        return i == 0 ? c.model : c.add[i - 1];
    };
    reporter.warn(
        fmt::format("{}: {} is {:.4g} times as large, so that the picture shows next to nothing of "
                    "the smaller: are both in the same unit? (--camera with numbers looks at it "
                    "from nearby)",
                    name(small), name(large), factor));
}

/// Lamps below a ground light nothing above it, or throw no shadow on it.
void warn_of_lights_below(const RenderJob& job, Reporter& reporter) {
    if (!job.wants("shaded") ||
        !lights_are_below_ground(job.light(), shade_view(job.camera, job.size)))
        return;
    reporter.warn(
        ground_color(job.config)
            ? "ground: every light is below it, and it is opaque: what is above gets ambient "
              "light alone (--light, --ground-height; --ground-color shadow lets light through)"
            : "ground: every light is below it: no shadow falls on it (--light, --ground-height)");
}

/// Panels have letters of their own; the SVG legends beside them take the reader's.
void warn_of_letters(const RenderConfig& config, Reporter& reporter) {
    if (const std::string unknown = without_glyphs(config.unit); !unknown.empty())
        reporter.warn(fmt::format(
            "unit \"{}\": pictures have no letters for {} and show boxes; SVG legends show them",
            config.unit, unknown));
}

/// What can be told before anything is drawn.
void check_job(const RenderJob& job, Reporter& reporter) {
    if (job.wants("truth_distance")) {
        const ModelHeader& drawn = job.header();
        refuse_far_truth(job.config,
                         {drawn.bounds.lo + drawn.origin, drawn.bounds.hi + drawn.origin});
    }
    warn_of_flat_surfels(job, reporter);
    warn_of_lights_below(job, reporter);
    warn_of_letters(job.config, reporter);
    warn_of_sizes(job, reporter);
}

/// How pictures become a film, and what is not as it should be in what was drawn.
void say_of_outcome(const RenderJob& job, const RenderOutcome& outcome, Reporter& reporter) {
    if (job.n_frames > 1)
        for (const std::string& command : film_commands(job.plan))
            reporter.info("as a film: " + command);
    if (outcome.truth_unknown > 0)
        reporter.warn(
            fmt::format("truth_distance: {} pixels are 0 for want of a nearest point of {} "
                        "(truth_unknown_pixels): is the model of that shape?",
                        outcome.truth_unknown, job.config.truth_shape));
    if (outcome.clamped > 0)
        reporter.warn(fmt::format(
            "{}: {} values of its colours are brighter than the {} that its numbers hold and are "
            "written as that (clamped_values): dim the lights",
            job.plan.exr.string(), outcome.clamped, kLargestHalf));
}

/// What of `--aov all` the model does not have, and how much of it was read.
void add_model_figures(const RenderConfig& config, const ModelFile& model, const ModelReads& reads,
                       Json& result) {
    const bool shows_colors = !model.colors().empty() && config.add.empty();
    for (const LeftOut& left : left_out_of_all(config.aov, model.header().degree, shows_colors,
                                               SaidBy::options))
        result["left_out"].push_back(left.aovs + ": " + left.reason);
    result["model_bytes"] = model.file_size();
    result["model_bytes_read"] = reads.bytes();
    result["model_nodes_checked"] = reads.n_checked();
}

/// Draws what a configuration asks for, or a share of its film; `manifest` is written last.
Json draw(const RenderConfig& config, const RenderShare& share, const fs::path& manifest,
          StageContext& context) {
    std::vector<std::string> aovs = wanted_aovs(config);
    const PictureSize size = parse_size(config.size);
    const int frames = check_request(config, aovs);
    const ModelFile model = ModelFile::open_by_pages(config.model);
    keep_possible_aovs(config, model.header().degree, !model.colors().empty(), aovs);
    Stamp stamp(context, manifest);
    add_inputs(config, model, stamp);
    add_outputs(config, aovs, share, stamp);
    if (config.repeat == 1)
        if (auto result = stamp.up_to_date()) return *result;

    const SurfelTree tree = model.tree();
    require_surfels(config, tree);
    ModelReads reads(model, takes_all_leaves(config, aovs), takes_colors(config, aovs));
    const OutputPlan plan = plan_outputs(config, aovs);
    check_outputs(config, plan);
    std::optional<TracedModels> traced;
    if (is_traced(config)) traced.emplace(config, tree);
    const std::vector<ScenePart> parts = scene_parts(tree, traced);
    const auto lines =
        wanted_lines(config, aovs, tree.header(), has_sharp(parts), context.reporter);
    std::vector<std::uint32_t> met;  // on the way to the bounds, in older files
    const ModelHeader header = traced ? traced->header() : drawn_header(tree, config.loose, &met);
    reads.meet(met);
    const FilmCameras cameras(config, header, size, legend_room(config, plan.framed(), size));
    RenderJob job{config, tree, aovs, plan, size, cameras.at(0),
                  lines, wanted_window(config, size), load_shadings(config, aovs, tree.header()),
                  frames, header, traced ? &*traced : nullptr, &reads, share};
    if (takes_colors(config, aovs)) job.shadings.colors.emplace(tree, model.colors());
    job.tints = tints_shaded(config, aovs);
    check_job(job, context.reporter);
    make_folder(job.plan);
    choose_looks(job, context.reporter);
    if (std::any_of(lines.begin(), lines.end(), is_crease))
        job.edges = edges_of(parts, config.loose, context.reporter);
    // What a picture took serves the next one: 9,000 pages of happy_stand_raw's at 1000 x 1000.
    if (frames > 1 || config.repeat > 1) keep_freed_memory(true);
    const RenderOutcome outcome = draw_film(job, cameras, model.identity(), context);
    say_of_outcome(job, outcome, context.reporter);
    Json result = make_result(job, outcome);
    add_model_figures(config, model, reads, result);
    return stamp.commit(std::move(result), Outlasts::power_cut, outcome.files);
}

Json drawn_or_joined(const RenderConfig& config, StageContext& context) {
    const RenderShare share = share_of(config);
    if (config.join > 0) return join_shares(config, context);
    const fs::path named = plan_outputs(config, wanted_aovs(config)).named;
    if (share.of == 0) return draw(config, {}, manifest_path(named), context);
    const fs::path folder = share_folder(named, share), manifest = share_target(named, share);
    make_writable_folder(is_film(config) ? folder.parent_path() : folder);
    return draw(config_of_share(config, share), share, manifest, context);
}

}  // namespace

Json run_render(const RenderConfig& config, StageContext& context) {
    if (!config.job.empty()) return draw_views(config, context);
    Json result = drawn_or_joined(config, context);
    context.text = render_summary(config, result);
    return result;
}

}  // namespace slim
