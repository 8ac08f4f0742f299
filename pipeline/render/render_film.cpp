#include "pipeline/render/render_film.h"

#include "pipeline/render/render_antialias.h"
#include "pipeline/render/render_frames.h"
#include "pipeline/render/render_inputs.h"
#include "pipeline/render/render_write.h"
#include "raytrace/lines/stroke.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// What to do about a picture of nothing.
std::string remedy_for(const RenderJob& job) {
    const std::string numbers =
        "--camera takes the eye, the target and the up axis in these coordinates; a named camera, "
        "as --camera iso, frames the whole model";
    const RenderConfig& c = job.config;
    if (!c.path.empty() || !is_camera_name(c.camera)) return numbers;
    if (c.zoom > 1)
        return fmt::format(
            "--zoom {:g} shows the middle of what {} frames, where the surface is open or away: a "
            "lower one shows more",
            c.zoom, c.camera);
    if (c.ortho_width > 0)
        return "--ortho-width fixes the scale: without it the whole model is framed";
    return fmt::format(
        "{} frames the whole model, whose surface lies between the middles of the pixels: a larger "
        "picture, or one less narrow, shows it",
        c.camera);
}

/// Parts of a picture may be empty.
void require_hits(const RenderJob& job, const RenderStats& stats) {
    if (stats.covered_pixels > 0 || !job.config.crop.empty() || !job.config.tile.empty()) return;
    const ModelHeader& m = job.header();
    const Vec3d lo = m.bounds.lo + m.origin, hi = m.bounds.hi + m.origin;
    throw NumericalError(fmt::format(
        "{}: not one of {}x{} pixels meets the surface: camera {}, model from ({:g}, {:g}, {:g}) "
        "to ({:g}, {:g}, {:g}). {}{}",
        job.config.model, job.size.width, job.size.height, describe(job.camera, m.origin), lo.x,
        lo.y, lo.z, hi.x, hi.y, hi.z, remedy_for(job),
        stats.loose_hidden > 0 ? "; --loose draws the loose surfels seen here" : ""));
}

void add(const RenderStats& part, RenderStats& sum) {
    sum.nodes_visited += part.nodes_visited;
    sum.surfels_drawn += part.surfels_drawn;
    sum.loose_hidden += part.loose_hidden;
    sum.root_tests += part.root_tests;
    sum.distance_tests += part.distance_tests;
    sum.blocks_passed += part.blocks_passed;
    sum.surfels_cut_off += part.surfels_cut_off;
    sum.unblended_pixels += part.unblended_pixels;
}

/// Bytes of a pixel of a frame with these planes.
std::uint64_t plane_bytes(const RenderJob& job, Channels channels) {
    GBuffer one;
    one.resize(1, 1, channels);
    std::uint64_t bytes = 1;
    one.for_each_plane([&](const auto& plane) { bytes += plane.size() * 4; });
    if (job.tints) bytes += 12;
    if (!job.traced) return bytes;
    // Normals turned to the eye, openness, clearance and model of each hit;
    // TracedPlanes::position_low.
    bytes += 12 + 4 + 4 + 2 + (job.traced->scene().is_wide() ? 12 : 0);
    // While openness is filtered: as it was, and hits as numbers; of a ground its own, places and
    // normals.
    if (job.config.ao || job.wants("ao")) bytes += 8 + (job.config.ground ? 4 + 25 : 0);
    return bytes;
}

/// Bytes that a pixel takes where lines are found: planes, and what they are blurred to.
std::uint64_t search_bytes(const RenderJob& job) {
    constexpr std::uint64_t kSearch = 20;
    return plane_bytes(job, job.channels(plain_aovs(job)) | job.for_lines()) + kSearch;
}

/// Bytes that a pixel of the picture takes while it is drawn: planes, the picture, its crop and its
/// bytes.
std::uint64_t pixel_bytes(const RenderJob& job) {
    const auto factor = static_cast<std::uint64_t>(job.config.supersample);
    const std::uint64_t plain =
        job.finds_lines() ? search_bytes(job) : plane_bytes(job, job.channels(plain_aovs(job)));
    return 36 + smoothing_bytes(job) + plain * (job.plan.exr.empty() ? 1 : 3) +
           factor * factor * plane_bytes(job, job.channels(fine_aovs(job)));
}

std::vector<PicturePart> parts_of(const RenderJob& job) {
    return picture_parts(job.size, job.window, pixel_bytes(job), shading_margin(job.size));
}

/// Whether the picture as a whole fits one band, its lines being found.
bool fits_one_band(const RenderJob& job) {
    return picture_parts(job.size, {0, 0, job.size.width, job.size.height}, pixel_bytes(job), 0)
               .size() == 1;
}

/// Lines are found in the frame that is drawn if that is all of the picture; else before,
/// in bands of their own.
void find_lines_before(RenderJob& job, StageContext& context, RenderOutcome& outcome) {
    job.found_lines.reset();
    const bool whole = job.window.width == job.size.width && job.window.height == job.size.height;
    if (!job.finds_lines() || (whole && parts_of(job).size() == 1)) return;
    const auto start = std::chrono::steady_clock::now();
    job.found_lines = find_lines(job, search_bytes(job), context);
    outcome.frame_ms += milliseconds_since(start);
}

/// The files of lines, of those that the wanted part shows; the first share of a picture writes
/// those of all of it.
void add_found_lines(const RenderJob& job, PictureFiles& files, RenderOutcome& outcome) {
    const bool is_share = job.share.of > 0 && job.n_frames == 1;
    if (!writes_lines(job.share, job.n_frames > 1)) return;
    const PixelWindow window =
        is_share ? PixelWindow{0, 0, job.size.width, job.size.height} : job.window;
    const auto shown = lines_within(*job.found_lines, job.size.width, job.size.height, window);
    const DrawnLines drawn{shown, job.lines, job.size, window};
    for (const NamedText& file :
         line_files(job.config, job.plan.lines_svg(), svg_scale(job.config, job.camera, job.size),
                    job.tree.header().origin, drawn))
        files.add_text(file);
    outcome.lines = lines_json(shown, job.lines);
}

/// One picture of each AOV, of a film or the only one; its files are not yet under their names.
PictureFiles draw_picture(RenderJob& job, const std::string& model_identity, StageContext& context,
                          RenderOutcome& outcome) {
    const ImageMetadata metadata =
        make_metadata(job.config, context.config, model_identity, job.tree.header(), job.camera,
                      job.size);
    find_lines_before(job, context, outcome);
    const auto parts = parts_of(job);
    PictureFiles files(job.plan, job.size, job.window, parts.size() == 1,
                       make_matrices(job.camera, job.size));
    std::optional<ContourDrawing> contours;
    if (writes_contours(job)) contours.emplace(job);
    // Pictures that are not averaged show the lines in the very frames that are drawn.
    const bool in_passing = job.config.supersample == 1 && job.share.of == 0;
    for (std::size_t band = 0; band < parts.size(); ++band) {
        if (parts.size() > 1) context.reporter.progress("bands", band, parts.size());
        Frames frames = draw_frames(job, parts[band], context);
        add(frames.stats, outcome.stats);
        outcome.stats.covered_pixels += frames.covered;
        outcome.smoothed_pixels += frames.n_smoothed;
        outcome.truth_unknown += frames.truth_unknown;
        outcome.frame_ms += frames.median_ms;
        outcome.light_rays += (frames.has_fine ? frames.fine : frames.plain).light_counts.rays;
        outcome.factor = frames.has_fine ? job.config.supersample : 1;
        if (parts.size() == 1 && job.n_frames == 1) require_hits(job, outcome.stats);
        if (contours && in_passing) contours->add(frames.plain, parts[band]);
        if (job.finds_lines()) job.found_lines = std::move(frames.lines);
        const std::string missing = write_band(job, frames, parts[band], metadata, files);
        if (!missing.empty() && outcome.frames == 0 && band == 0)
            context.reporter.warn(missing);
    }
    if (job.n_frames == 1) require_hits(job, outcome.stats);
    if (!job.lines.empty()) add_found_lines(job, files, outcome);
    if (contours) {
        const PixelWindow shown =
            job.share.of == 0 ? job.window : PixelWindow{0, 0, job.size.width, job.size.height};
        if (!in_passing) add_contours(job, shown, context, *contours);
        if (const auto drawing = contours->finish(shown, context.reporter))
            files.add_text(*drawing);
    }
    outcome.whole_at_once = fits_one_band(job);
    outcome.plane_bytes = plane_bytes(
        job, job.channels(job.aovs) | line_channels(job.lines, job.tree.header().degree));
    outcome.clamped += files.n_clamped();
    ++outcome.frames;
    return files;
}

void commit(std::vector<PictureFiles>& pictures, RenderOutcome& outcome) {
    for (PictureFiles& picture : pictures)
        for (const fs::path& file : picture.commit()) outcome.files.push_back(file);
    pictures.clear();
}

}  // namespace

RenderOutcome draw_film(RenderJob& job, const FilmCameras& cameras,
                        const std::string& model_identity, StageContext& context) {
    const OutputPlan plan = job.plan;
    const FrameRange range = wanted_frames(job.config, job.share);
    RenderOutcome outcome;
    std::vector<PictureFiles> held;  // of a film, until a picture of it shows something
    for (int k = range.first; k <= range.last; ++k) {
        if (job.n_frames > 1) {
            context.reporter.progress("pictures", static_cast<std::uint64_t>(k - range.first),
                                      static_cast<std::uint64_t>(range.last - range.first + 1));
            job.camera = cameras.at(k - 1);
            job.plan = plan.numbered(k);
        }
        held.push_back(draw_picture(job, model_identity, context, outcome));
        if (k == range.last)
            for (const NamedText& legend : legend_files(job)) held.back().add_text(legend);
        held.back().seal();
        if (outcome.stats.covered_pixels > 0) commit(held, outcome);
    }
    job.plan = plan;
    // the whole has some, or is refused when it is joined
    if (job.share.of == 0) require_hits(job, outcome.stats);
    commit(held, outcome);
    return outcome;
}

}  // namespace slim
