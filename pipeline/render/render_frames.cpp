#include "pipeline/render/render_frames.h"

#include "pipeline/median.h"
#include "pipeline/render/render_antialias.h"
#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_directions.h"
#include "pipeline/render/render_maps.h"
#include "raytrace/brute/brute_renderer.h"
#include "raytrace/project/forward_renderer.h"

#include <algorithm>
#include <chrono>

namespace slim {
namespace {

RenderStats render_surface(const RenderJob& job, const RenderRequest& request,
                           RenderedFrame& frame) {
    if (job.traced)
        return render_traced(job.traced->scene(), request, frame.buffer, &frame.traced,
                             frame.only);
    return job.config.mode == "brute" ? render_brute(job.tree, request, frame.buffer)
                                      : render_forward(job.tree, request, frame.buffer, frame.only);
}

}  // namespace

namespace {

/// What of a frame does not depend on how it is drawn.
void place_frame(const RenderJob& job, const PictureSize& size, const PixelWindow& window,
                 RenderedFrame& frame) {
    frame.size = size, frame.window = window;
    frame.pixels = pixel_view(job.camera, size.width, size.height);
    frame.view = shade_view(job.camera, size, window.x, window.y);
    frame.diagonals.clear();
    if (job.models().size() > 1)
        for (const ModelHeader* model : job.models()) frame.diagonals.push_back(model->diagonal);
}

RenderRequest request_of(const RenderJob& job, const PictureSize& size, const PixelWindow& window,
                         double lod, Channels wanted) {
    RenderRequest request{job.camera, size.width, size.height,     wanted,
                          lod,        window,     job.config.loose};
    request.clean_outlines = job.config.clean_outlines;
    request.hessians = job.hessians.get();
    if (!job.reads->whole()) request.on_met = [&](auto nodes) { job.reads->meet(nodes); };
    return request;
}

}  // namespace

RenderStats draw_buffer(const RenderJob& job, const PictureSize& size, const PixelWindow& window,
                        double lod, Channels wanted, RenderedFrame& frame) {
    place_frame(job, size, window, frame);
    return render_surface(job, request_of(job, size, window, lod, wanted), frame);
}

namespace {

/// The lines of a picture that the frame holds as a whole.
std::vector<FeatureLine> lines_of_frame(const RenderJob& job, RenderedFrame& frame) {
    PictureLines search(job.line_models(), job.lines);
    search.add(0, frame.buffer.height, frame);
    return search.finish();
}

/// What the pictures of a frame are painted from besides its planes: openness and shading. One
/// pixel of the picture for `factor` x `factor` of the frame.
void light_frame(const RenderJob& job, int factor, bool with_shading, RenderedFrame& frame) {
    frame.light_counts = {};
    const FrameLight light = job.light();
    // The plain frame beside a fine one may be for ids only.
    const bool has_surface = frame.buffer.has(kNormalChannel | kPositionChannel);
    if (has_surface && (job.wants("ao") || (with_shading && job.config.ao)))
        find_openness(light, frame);
    if (with_shading) shade_frame(light, factor, frame);
}

void drop_directions(const RenderJob& job, RenderedFrame& frame) {
    const bool shows_some =
        std::any_of(job.aovs.begin(), job.aovs.end(), [](const std::string& aov) {
            return aov == "dir1" || aov == "dir2" || is_third_order(aov);
        });
    if (!shows_some || !frame.buffer.has(kK1Channel | kK2Channel) ||
        !frame.buffer.has_any(kDirectionChannel | kThirdOrderChannel))
        return;
    drop_undefined_directions(frame.diagonals.empty()
                                  ? PixelDiagonals(job.tree.header().diagonal)
                                  : PixelDiagonals(frame.diagonals, frame.traced.model),
                              frame.buffer);
}

/// Projection, shading and lines: what a frame time means.
RenderStats draw_frame(const RenderJob& job, int factor, Channels wanted, bool with_shading,
                       const PicturePart& part, RenderedFrame& frame,
                       std::vector<FeatureLine>& lines) {
    // LOD pixels are the picture's own: supersampling smooths edges, it does not refine the model.
    const RenderStats stats =
        draw_buffer(job, {job.size.width * factor, job.size.height * factor},
                    times(part.drawn, factor), job.config.lod * factor, wanted, frame);
    light_frame(job, factor, with_shading, frame);
    // Lines are found at the picture's own size: their strokes are smooth as they are.
    if (factor == 1 && job.finds_lines()) lines = lines_of_frame(job, frame);
    // Lines have a rule of their own for umbilics, so this comes after them.
    drop_directions(job, frame);
    return stats;
}

/// Renders the frame of a factor as often as the job says; returns the median time.
double draw_repeatedly(const RenderJob& job, int factor, Channels wanted, const PicturePart& part,
                       StageContext& context, RenderedFrame& frame, Frames& frames) {
    std::vector<double> times;
    const auto repeats = static_cast<std::uint64_t>(job.config.repeat);
    for (std::uint64_t k = 0; k < repeats; ++k) {
        if (repeats > 1)
            context.reporter.progress("frames", k,
                                      repeats);  // of one picture: those of a film are told
        const auto start = std::chrono::steady_clock::now();
        frames.stats =
            draw_frame(job, factor, wanted, job.wants("shaded"), part, frame, frames.lines);
        if (job.antialiases()) smooth_edges(job, part, frames);
        times.push_back(milliseconds_since(start));
    }
    return median(times);
}

std::uint64_t count_hits(const GBuffer& b, const PixelWindow& w) {
    std::uint64_t n = 0;
    for (int y = w.y; y < w.y + w.height; ++y)
        n += static_cast<std::uint64_t>(
            std::count(&b.hit[b.index(w.x, y)], &b.hit[b.index(w.x, y)] + w.width, 1));
    return n;
}

}  // namespace

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

/// What the plain frame is for: data files take all, pictures only what is never averaged.
std::vector<std::string> plain_aovs(const RenderJob& job) {
    std::vector<std::string> aovs = job.aovs;
    if (job.config.supersample > 1 && job.plan.exr.empty()) std::erase_if(aovs, is_filterable);
    return aovs;
}

std::vector<std::string> averaged_aovs(const RenderJob& job) {
    std::vector<std::string> aovs;
    for (const std::string& aov : job.aovs) {
        const bool drawn =
            std::find(job.plan.drawn.begin(), job.plan.drawn.end(), aov) != job.plan.drawn.end();
        if (is_filterable(aov) && (drawn || is_color(aov))) aovs.push_back(aov);
    }
    return aovs;
}

std::vector<std::string> fine_aovs(const RenderJob& job) {
    return job.config.supersample == 1 ? std::vector<std::string>() : averaged_aovs(job);
}

namespace {

PictureSize sample_size(const RenderJob& job) {
    return {job.size.width * SampleMask::kSide, job.size.height * SampleMask::kSide};
}

RenderRequest sample_request(const RenderJob& job, const PixelWindow& window, Channels wanted) {
    return request_of(job, sample_size(job), samples_of(window),
                      job.config.lod * SampleMask::kSide, wanted);
}

}  // namespace

SampleDrawing::SampleDrawing(const RenderJob& job, const SampleMask& only,
                             const CoarsePlanes* around, Channels wanted)
    : job_(job), only_(only), around_(around), wanted_(wanted) {
    if (!job.traced)
        ready_.emplace(job.tree, sample_request(job, only.part(), wanted), &only);
}

void SampleDrawing::draw(const PixelWindow& window, RenderedFrame& frame) const {
    frame.only = &only_;
    place_frame(job_, sample_size(job_), samples_of(window), frame);
    if (ready_) ready_->draw(frame.window, frame.buffer);
    else
        render_surface(job_, sample_request(job_, window, wanted_), frame);
    frame.view.around = around_;
    light_frame(job_, SampleMask::kSide, job_.wants("shaded"), frame);
    drop_directions(job_, frame);
}

Frames draw_frames(const RenderJob& job, const PicturePart& part, StageContext& context) {
    const auto plain = plain_aovs(job), fine = fine_aovs(job);
    const Channels plain_channels = job.channels(plain) | job.for_lines();
    Frames frames;
    frames.has_fine = !fine.empty();
    if (frames.has_fine) {
        frames.median_ms = draw_repeatedly(job, job.config.supersample, job.channels(fine),
                                           part, context, frames.fine, frames);
        if (!plain.empty() || job.finds_lines())
            draw_frame(job, 1, plain_channels, false, part, frames.plain, frames.lines);
    } else {
        frames.median_ms =
            draw_repeatedly(job, 1, plain_channels, part, context, frames.plain, frames);
    }
    frames.covered = frames.has_fine ? count_hits(frames.fine.buffer,
                                                  times(part.inside(), job.config.supersample))
                                     : count_hits(frames.plain.buffer, part.inside());
    if (job.wants("truth_distance"))
        frames.plain.truth_distance = truth_distances(job.config, job.tree.header().origin,
                                                      frames.plain.buffer, &frames.truth_unknown);
    return frames;
}

std::vector<FeatureLine> find_lines(const RenderJob& job, std::uint64_t pixel_bytes,
                                    StageContext& context) {
    const Channels channels = job.channels(plain_aovs(job)) | job.for_lines();
    const PixelWindow whole{0, 0, job.size.width, job.size.height};
    const auto parts =
        picture_parts(job.size, whole, pixel_bytes, line_margin(job.size.width, job.size.height));
    PictureLines search(job.line_models(), job.lines);
    RenderedFrame frame;
    for (std::size_t band = 0; band < parts.size(); ++band) {
        if (parts.size() > 1) context.reporter.progress("bands for lines", band, parts.size());
        draw_buffer(job, job.size, parts[band].drawn, job.config.lod, channels, frame);
        const PixelWindow inside = parts[band].inside();
        search.add(inside.y, inside.y + inside.height, frame);
    }
    return search.finish();
}

void add_contours(const RenderJob& job, const PixelWindow& window, StageContext& context,
                  ContourDrawing& drawing) {
    constexpr Channels kShape = kPositionChannel | kNormalChannel;
    constexpr std::uint64_t kPixelBytes = 40;  // 25 of the planes
    constexpr int kRowBelow = 1;
    const auto parts = picture_parts(job.size, window, kPixelBytes, kRowBelow);
    RenderedFrame frame;
    for (std::size_t band = 0; band < parts.size(); ++band) {
        if (parts.size() > 1) context.reporter.progress("bands for contours", band, parts.size());
        draw_buffer(job, job.size, parts[band].drawn, job.config.lod, kShape, frame);
        drawing.add(frame, parts[band]);
    }
}

}  // namespace slim
