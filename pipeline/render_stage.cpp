#include "pipeline/render_stage.h"

#include "formats/image_io.h"
#include "formats/model_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/ray_options.h"
#include "pipeline/render_edges.h"
#include "pipeline/render_frames.h"
#include "pipeline/render_maps.h"
#include "pipeline/render_trace.h"
#include "pipeline/render_write.h"
#include "raytrace/font.h"
#include "raytrace/project/lod_cut.h"
#include "raytrace/project/tile_bins.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace slim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Nodes that a view of that size visits.
void visit_view(const RenderJob& job, const Camera& camera, const PictureSize& size,
                const PixelWindow& window, double lod, std::vector<std::uint32_t>& visited) {
    CutCounts counts;
    counts.visited = &visited;
    lod_cut(job.tree, pixel_view(camera, size.width, size.height), whole_tiles(window),
            {lod, job.config.loose}, counts);
}

/// The same of the pictures that ranges are taken from.
void visit_references(const RenderJob& job, std::vector<std::uint32_t>& visited) {
    const PictureSize size = reference_size(job.size);
    const PixelWindow all{0, 0, size.width, size.height};
    const double lod = job.config.lod * reference_scale(job.size);
    visit_view(job, job.camera, size, all, lod, visited);
    for (const std::string& name : job.config.same_range)
        visit_view(job, camera_of_range(job, name), size, all, lod, visited);
}

/// Whether a picture takes all of the model: rays and the blend of colours go through trees
/// of all its leaves.
bool takes_all_leaves(const RenderConfig& config, const std::vector<std::string>& aovs) {
    return config.mode != "forward" || std::find(aovs.begin(), aovs.end(), "color") != aovs.end();
}

/// Models up to this size are checked whole, checksums and all: for 2.7 MB that is below the noise of a run of
/// 0.24 s.
constexpr std::uint64_t kCheckedWhole = std::uint64_t{16} << 20;

/// Checks what will be drawn of the model; returns the bytes of it that are read. A view of a part
/// of a large model reads the pages that it shows and checks the nodes and records in them by
/// themselves, without the checksum of the chunks that they are part of: that is one of the whole
/// chunk. Where the pages are half of the file or more, or the file is small, all of it is checked
/// as elsewhere. What takes_all_leaves has been checked. `visited` are the nodes that were read
/// before.
std::uint64_t check_what_is_drawn(const ModelFile& model, const RenderJob& job,
                                  std::vector<std::uint32_t> visited) {
    if (takes_all_leaves(job.config, job.aovs)) return model.file_size();
    if (model.file_size() > kCheckedWhole && job.tree.sharp().empty() && job.n_frames == 1) {
        visit_view(job, job.camera, job.size, drawn_window(job.window, job.size), job.config.lod,
                   visited);
        if (!reference_aovs(job).empty()) visit_references(job, visited);
        const std::uint64_t bytes = model.bytes_of_pages(visited);
        if (2 * bytes < model.file_size()) return model.check(visited), bytes;
    }
    model.check();
    return model.file_size();
}

/// What a run came to.
struct Outcome {
    RenderStats stats;
    double frame_ms = 0;  ///< of all bands
    int factor = 1;
    int frames = 0;
    std::uint64_t light_rays = 0;  ///< all but the primary ones
    Json lines;
    std::vector<fs::path> files;
};

/// Parts of a picture may be empty.
void require_hits(const RenderJob& job, const RenderStats& stats) {
    if (stats.covered_pixels > 0 || !job.config.crop.empty() || !job.config.tile.empty()) return;
    const ModelHeader& m = job.header();
    const Vec3d lo = m.bounds.lo + m.origin, hi = m.bounds.hi + m.origin;
    throw NumericalError(
        fmt::format("{}: not one of {}x{} pixels meets the surface: camera {}, model from ({:g}, "
                    "{:g}, {:g}) to "
                    "({:g}, {:g}, {:g}). --camera takes the eye, the target and the up axis in "
                    "these coordinates; "
                    "a named camera, as --camera iso, frames the whole model{}",
                    job.config.model, job.size.width, job.size.height,
                    describe(job.camera, m.origin), lo.x, lo.y, lo.z, hi.x, hi.y, hi.z,
                    stats.loose_hidden > 0 ? "; --loose draws the loose surfels seen here" : ""));
}

void add(const RenderStats& part, RenderStats& sum) {
    sum.nodes_visited += part.nodes_visited;
    sum.surfels_drawn += part.surfels_drawn;
    sum.loose_hidden += part.loose_hidden;
    sum.root_tests += part.root_tests;
    sum.distance_tests += part.distance_tests;
    sum.unblended_pixels += part.unblended_pixels;
}

/// Bytes that a pixel of the picture takes while it is drawn: planes, the picture, its crop and its
/// bytes.
std::uint64_t pixel_bytes(const RenderJob& job) {
    const auto planes = [&](const std::vector<std::string>& aovs) {
        GBuffer one;
        one.resize(1, 1, job.channels(aovs));
        std::uint64_t bytes = 1;
        one.for_each_plane([&](const auto& plane) { bytes += plane.size() * 4; });
        // Normals turned to the eye, openness, clearance and model of each hit.
        return bytes + (job.traced ? 12 + 4 + 4 + 2 : 0);
    };
    const auto factor = static_cast<std::uint64_t>(job.config.supersample);
    return 36 + planes(plain_aovs(job)) * (job.plan.exr.empty() ? 1 : 3) +
           factor * factor * planes(fine_aovs(job));
}

/// One picture of each AOV, of a film or the only one.
void draw_and_write(const RenderJob& job, const std::string& model_identity, StageContext& context,
                    Outcome& outcome) {
    const ImageMetadata metadata =
        make_metadata(job.config, context.config, model_identity, job.tree.header(), job.camera);
    const auto parts = picture_parts(job.size, job.window, pixel_bytes(job), !job.lines.empty());
    PictureFiles files(job.plan, job.size, job.window, parts.size() == 1,
                       make_matrices(job.camera, job.size));
    for (std::size_t band = 0; band < parts.size(); ++band) {
        if (parts.size() > 1) context.reporter.progress("bands", band, parts.size());
        const Frames frames = draw_frames(job, parts[band], context);
        add(frames.stats, outcome.stats);
        outcome.stats.covered_pixels += frames.covered;
        outcome.frame_ms += frames.median_ms;
        outcome.light_rays += (frames.has_fine ? frames.fine : frames.plain).light_counts.rays;
        outcome.factor = frames.has_fine ? job.config.supersample : 1;
        if (parts.size() == 1 && job.n_frames == 1) require_hits(job, outcome.stats);
        if (!write_band(job, frames, parts[band], metadata, files) && outcome.frames == 0 &&
            band == 0)
            context.reporter.warn(
                job.plan.named.string() +
                ": too small for its legend or scale bar; legends are beside it as SVG");
        if (job.lines.empty()) continue;
        for (const auto& file :
             write_lines(job.config, job.plan.lines_svg(), job.size, job.tree.header().origin,
                         frames.plain.lines, job.lines))
            outcome.files.push_back(file);
        outcome.lines = lines_json(frames.plain.lines, job.lines);
    }
    if (job.n_frames == 1) require_hits(job, outcome.stats);
    const auto pictures = files.commit();
    outcome.files.insert(outcome.files.end(), pictures.begin(), pictures.end());
    ++outcome.frames;
}

/// All pictures of the run; legends are those of the whole film.
Outcome draw_film(RenderJob& job, double free_right, const std::string& model_identity,
                  StageContext& context) {
    const OutputPlan plan = job.plan;
    const int wanted = job.config.frame;
    Outcome outcome;
    for (int k = wanted > 0 ? wanted : 1; k <= (wanted > 0 ? wanted : job.n_frames); ++k) {
        if (job.n_frames > 1) {
            context.reporter.progress("pictures", static_cast<std::uint64_t>(k - 1),
                                      static_cast<std::uint64_t>(job.n_frames));
            job.camera = frame_camera(job.config, job.header(), job.size, free_right, k - 1);
            job.plan = plan.numbered(k);
        }
        draw_and_write(job, model_identity, context, outcome);
    }
    job.plan = plan;
    require_hits(job, outcome.stats);
    for (const fs::path& file : write_legends(job)) outcome.files.push_back(file);
    return outcome;
}

Json ranges_json(const RenderJob& job) {
    Json ranges = Json::object();
    for (const std::string& aov : job.plan.drawn)
        if (const auto& legend = job.looks.at(aov).legend)
            ranges[aov] = Json::array({legend->range.lo, legend->range.hi});
    return ranges;
}

Json make_result(const RenderJob& job, const Outcome& outcome) {
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
                   {"unblended_pixels", s.unblended_pixels},
                   {"frame_ms_median", outcome.frame_ms / outcome.frames},
                   {"ranges", ranges_json(job)}};
    if (job.traced) {
        result["light_rays"] = outcome.light_rays;
        result["scene_ms"] = job.traced->build_ms();
    }
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

void require_scale(const RenderJob& job) {
    if (job.config.scale_bar && !job.camera.orthographic)
        throw ConfigError(
            "scale_bar: a perspective picture has no one scale: draw it with --ortho");
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

/// Panels have letters of their own; the SVG legends beside them take the reader's.
void warn_of_letters(const RenderConfig& config, Reporter& reporter) {
    if (const std::string unknown = without_glyphs(config.unit); !unknown.empty())
        reporter.warn(fmt::format(
            "unit \"{}\": pictures have no letters for {} and show boxes; SVG legends show them",
            config.unit, unknown));
}

/// What can be wrong before the model is opened. Returns the number of pictures.
int check_request(const RenderConfig& config, const std::vector<std::string>& aovs) {
    check_view_name(config.name);
    check_ranges(config);
    check_lines(config, aovs);
    check_shadings(config);
    check_tracing(config, aovs);
    parse_background(config.background, false);
    const int frames = n_frames(config);
    if (frames > 1 && !(config.lines_ply + config.lines_obj).empty())
        throw ConfigError(
            "lines_ply and lines_obj are for one picture, not for a turntable or path");
    require_model(config.model);
    return frames;
}

/// All that the pictures depend on.
void add_inputs(const RenderConfig& config, const ModelFile& model, const fs::path& named,
                Stamp& stamp) {
    stamp.input(config.model, model.identity());
    for (const std::string& file : {config.environment, config.matcap})
        if (!file.empty()) stamp.input(file);
    for (const std::string& added : config.add) stamp.input(added);
    stamp.depends("drawn as " + named.stem().string());
    for (const std::string& file : {config.lines_ply, config.lines_obj})
        stamp.depends("lines to " + file);
    if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) stamp.depends(epoch);
}

/// No file of the run may be one that it reads, by whatever name.
void refuse_to_overwrite_inputs(const RenderConfig& config, const OutputPlan& plan) {
    std::vector<fs::path> outputs = plan.pngs;
    outputs.push_back(plan.exr);
    for (const std::string& aov : plan.drawn) outputs.push_back(plan.legend(aov));
    outputs.push_back(plan.lines_svg());
    for (const fs::path& output : outputs) {
        refuse_to_overwrite(output.string(), {config.model, config.environment, config.matcap});
        for (const std::string& added : config.add) refuse_to_overwrite(output.string(), {added});
    }
}

}  // namespace

Json run_render(const RenderConfig& config, StageContext& context) {
    std::vector<std::string> aovs = wanted_aovs(config);
    const PictureSize size = parse_size(config.size);
    const int frames = check_request(config, aovs);
    const fs::path named = plan_outputs(config, aovs).named;
    for (int k = 0; k <= (frames > 1 ? frames : 0); ++k) {
        const OutputPlan pictures = plan_outputs(config, aovs);
        refuse_to_overwrite_inputs(config, k > 0 ? pictures.numbered(k) : pictures);
    }
    const ModelFile model = ModelFile::open_by_pages(config.model);
    Stamp stamp(context, manifest_path(named.string()));
    add_inputs(config, model, named, stamp);
    if (config.repeat == 1)
        if (auto result = stamp.up_to_date()) return *result;

    const SurfelTree tree = model.tree();
    require_surfels(config, tree);
    keep_possible_aovs(config, tree.header().degree, !model.colors().empty(), aovs);
    if (takes_all_leaves(config, aovs)) model.check();
    const OutputPlan plan = plan_outputs(config, aovs);
    refuse_to_overwrite_inputs(config, plan);
    const double room = legend_room(config, size);
    std::optional<TracedModels> traced;
    if (is_traced(config)) traced.emplace(config, tree);
    const std::vector<ScenePart> parts = scene_parts(tree, traced);
    const auto lines = wanted_lines(config, aovs, tree.header(), has_sharp(parts), context.reporter);
    std::vector<std::uint32_t> met;  // on the way to the bounds
    const ModelHeader header = traced ? traced->header() : drawn_header(tree, config.loose, &met);
    RenderJob job{config,
                  tree,
                  aovs,
                  plan,
                  size,
                  frame_camera(config, header, size, room, 0),
                  lines,
                  wanted_window(config, size, !lines.empty()),
                  load_shadings(config, aovs, tree.header()),
                  frames,
                  header,
                  traced ? &*traced : nullptr};
    if (job.wants("color")) job.shadings.colors.emplace(tree, model.colors());
    require_scale(job);
    warn_of_flat_surfels(job, context.reporter);
    warn_of_letters(config, context.reporter);
    const std::uint64_t bytes_read = check_what_is_drawn(model, job, std::move(met));
    make_folder(job.plan);
    choose_looks(job);
    if (std::any_of(lines.begin(), lines.end(), is_crease)) job.edges = edges_of(parts, config.loose);
    const Outcome outcome = draw_film(job, room, model.identity(), context);
    if (frames > 1)
        for (const std::string& command : film_commands(job.plan))
            context.reporter.info("as a film: " + command);
    Json result = make_result(job, outcome);
    result["model_bytes"] = model.file_size();
    result["model_bytes_read"] = bytes_read;
    return stamp.commit(outcome.files, std::move(result));
}

}  // namespace slim
