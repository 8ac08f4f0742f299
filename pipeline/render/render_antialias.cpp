#include "pipeline/render/render_antialias.h"

#include "pipeline/render/render_frames.h"
#include "raytrace/picture_edges.h"
#include "raytrace/sample_mask.h"

#include <algorithm>

namespace slim {
namespace {

/// Of windows that samples are drawn in: small ones leave out more of what shows no edge.
constexpr int kWindowWidth = 256, kWindowHeight = 64;
/// Windows begin with whole tiles of the doubled picture, as parts of a picture do.
constexpr int kAlign = 16;

/// An AOV's picture and which of its pixels are edges.
struct EdgePicture {
    const std::string& aov;
    Picture& picture;
    std::vector<std::uint8_t> marks;
};

/// Strokes of lines are smooth as they are, and drawn later.
std::vector<std::string> smoothed_aovs(const RenderJob& job) {
    std::vector<std::string> aovs = averaged_aovs(job);
    std::erase(aovs, "lines");
    return aovs;
}

AovLook look_of(const RenderJob& job, const std::string& aov) {
    const auto found = job.looks.find(aov);  // a colour in a data file has none
    return found == job.looks.end() ? AovLook{} : found->second;
}

Picture& paint_plain(const RenderJob& job, const std::string& aov, Frames& frames) {
    if (aov == "shaded") return frames.plain.shaded;
    return frames.smoothed[aov] = draw_aov(job.config, aov, look_of(job, aov), job.shadings,
                                           frames.plain, job.header().bounds, job.size);
}

/// Marks in the margin of a part are of no use.
void clear_margin(const PixelWindow& inside, int width, std::vector<std::uint8_t>& marks) {
    const auto w = static_cast<std::size_t>(width);
    for (std::size_t y = 0; y * w < marks.size(); ++y) {
        const auto row = marks.begin() + static_cast<std::ptrdiff_t>(y * w);
        const bool is_in = static_cast<int>(y) >= inside.y &&
                           static_cast<int>(y) < inside.y + inside.height;
        std::fill_n(row, is_in ? inside.x : width, std::uint8_t{0});
        if (is_in) std::fill(row + inside.x + inside.width, row + width, std::uint8_t{0});
    }
}

std::vector<EdgePicture> edge_pictures(const RenderJob& job,
                                       const std::vector<std::string>& aovs,
                                       const PicturePart& part, Frames& frames) {
    std::vector<EdgePicture> out;
    for (const std::string& aov : aovs) {
        Picture& picture = paint_plain(job, aov, frames);
        out.push_back({aov, picture, edge_pixels(picture)});
        clear_margin(part.inside(), picture.width, out.back().marks);
    }
    return out;
}

SampleMask all_marks(const std::vector<EdgePicture>& pictures, const PixelWindow& part) {
    SampleMask mask(part);
    for (const EdgePicture& p : pictures)
        std::transform(p.marks.begin(), p.marks.end(), mask.wanted().begin(),
                       mask.wanted().begin(),
                       [](std::uint8_t a, std::uint8_t b) -> std::uint8_t { return a | b; });
    return mask;
}

/// A window grown to whole tiles of samples, as far as a part goes.
PixelWindow aligned(const PixelWindow& w, const PixelWindow& part) {
    const auto up = [](int n) { return (n + kAlign - 1) / kAlign * kAlign; };
    const int x = w.x / kAlign * kAlign, y = w.y / kAlign * kAlign;
    return {x, y, std::min(up(w.x + w.width), part.x + part.width) - x,
            std::min(up(w.y + w.height), part.y + part.height) - y};
}

/// The windows that hold all samples, in the order in which they lie.
std::vector<PixelWindow> sample_windows(const SampleMask& mask) {
    const PixelWindow& part = mask.part();
    std::vector<PixelWindow> out;
    for (int y = part.y; y < part.y + part.height; y += kWindowHeight)
        for (int x = part.x; x < part.x + part.width; x += kWindowWidth) {
            const PixelWindow about = mask.bounds_in({x, y, kWindowWidth, kWindowHeight});
            if (about.width > 0) out.push_back(aligned(about, part));
        }
    return out;
}

/// Copies the marked pixels of a window's picture into that of the part.
void copy_marked(const Picture& from, const PixelWindow& window, const PixelWindow& part,
                 EdgePicture& to) {
    const int x0 = window.x - part.x, y0 = window.y - part.y;
    for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.width; ++x)
            if (to.marks[to.picture.index(x0 + x, y0 + y)])
                std::copy_n(from.pixel(x, y), 4, to.picture.pixel(x0 + x, y0 + y));
}

bool looks_at_neighbours(const RenderJob& job) { return job.wants("ao") || job.config.ao; }

/// What lies about samples: the plain frame. Nothing where it has no normals.
CoarsePlanes planes_around(const RenderedFrame& plain) {
    const GBuffer& b = plain.buffer;
    return {b.hit,   {b.normal[0], b.normal[1], b.normal[2]}, plain.window.x, plain.window.y,
            b.width, b.height};
}

}  // namespace

void smooth_edges(const RenderJob& job, const PicturePart& part, Frames& frames) {
    const std::vector<std::string> aovs = smoothed_aovs(job);
    std::vector<EdgePicture> pictures = edge_pictures(job, aovs, part, frames);
    const SampleMask marked = all_marks(pictures, part.drawn);
    frames.n_smoothed = static_cast<std::uint64_t>(
        std::count(marked.wanted().begin(), marked.wanted().end(), 1));
    // Openness is filtered over the samples about a sample.
    const SampleMask drawn = looks_at_neighbours(job) ? marked.grown() : marked;
    const CoarsePlanes around = planes_around(frames.plain);
    const bool has_normals = frames.plain.buffer.has(kNormalChannel);
    RenderedFrame samples;
    for (const PixelWindow& window : sample_windows(drawn)) {
        draw_samples(job, window, drawn, has_normals ? &around : nullptr, job.channels(aovs),
                     samples);
        frames.plain.light_counts += samples.light_counts;
        for (EdgePicture& p : pictures)
            copy_marked(p.aov == "shaded"
                            ? samples.shaded
                            : draw_aov(job.config, p.aov, look_of(job, p.aov), job.shadings,
                                       samples, job.header().bounds, job.size),
                        window, part.drawn, p);
    }
}

std::uint64_t smoothing_bytes(const RenderJob& job) {
    constexpr std::uint64_t kPictureAndMarks = 17, kMasks = 2;
    return job.antialiases() ? kMasks + kPictureAndMarks * smoothed_aovs(job).size() : 0;
}

Picture painted_aov(const RenderJob& job, const std::string& aov, const AovLook& look,
                    const Frames& frames) {
    if (const auto found = frames.smoothed.find(aov); found != frames.smoothed.end())
        return found->second;
    return draw_aov(job.config, aov, look, job.shadings, frames.for_aov(aov), job.header().bounds,
                    job.size);
}

}  // namespace slim
