#include "pipeline/render/render_antialias.h"

#include "pipeline/render/render_frames.h"
#include "raytrace/picture_edges.h"
#include "raytrace/sample_mask.h"
#include "raytrace/trace/openness_filter.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>

namespace slim {
namespace {

/// Windows begin where lanes of the doubled picture do; drawn by rays with whole tiles of it, as
/// parts of a picture do.
constexpr int kLanesAlign = 8, kTilesAlign = 16;
static_assert(kLanesAlign * SampleMask::kSide % kLanes == 0);
/// Sides of windows that samples are drawn in. Small ones leave out more of what shows no edge;
/// drawn by rays each sets up its lights anew.
constexpr int kProjected = 16, kTraced = 64;
/// Windows that a thread draws one after the other, into the same memory.
constexpr std::size_t kWindowGrain = 4;

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

Picture painted(const RenderJob& job, const std::string& aov, const RenderedFrame& frame) {
    return draw_aov(job.config, aov, look_of(job, aov), job.shadings, frame, job.header().bounds,
                    job.size);
}

Picture& paint_plain(const RenderJob& job, const std::string& aov, Frames& frames) {
    if (aov == "shaded") return frames.plain.shaded;
    return frames.smoothed[aov] = painted(job, aov, frames.plain);
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
    // Rays see shadows on a ground, too, where nothing is hit.
    std::span<const std::uint8_t> covered;
    if (!job.traced) covered = frames.plain.buffer.hit;
    for (const std::string& aov : aovs) {
        Picture& picture = paint_plain(job, aov, frames);
        out.push_back({aov, picture, edge_pixels(picture, kEdgeContrast, covered)});
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

/// A window grown by a margin and to multiples of some pixels, as far as a part goes.
PixelWindow with_margin(const PixelWindow& w, int margin, int align, const PixelWindow& part) {
    const auto down = [&](int n, int least) { return std::max(n - margin, least) / align * align; };
    const auto up = [&](int n, int most) {
        return std::min((n + margin + align - 1) / align * align, most);
    };
    const int x = down(w.x, part.x), y = down(w.y, part.y);
    return {x, y, up(w.x + w.width, part.x + part.width) - x,
            up(w.y + w.height, part.y + part.height) - y};
}

/// A rectangle of the picture, and what is drawn for it.
struct SampleWindow {
    PixelWindow wanted, drawn;
};

/// Windows that hold all wanted pixels, each in one, and `margin` pixels about these.
std::vector<SampleWindow> sample_windows(const SampleMask& mask, int side, int margin, int align) {
    const PixelWindow& part = mask.part();
    std::vector<SampleWindow> out;
    for (int y = part.y; y < part.y + part.height; y += side)
        for (int x = part.x; x < part.x + part.width; x += side) {
            const PixelWindow w = mask.bounds_in({x, y, side, side});
            if (w.width > 0) out.push_back({w, with_margin(w, margin, align, part)});
        }
    return out;
}

/// Copies the marked pixels that are wanted of a window from its picture into that of the part.
void copy_marked(const Picture& from, const SampleWindow& window, const PixelWindow& part,
                 EdgePicture& to) {
    const PixelWindow& w = window.wanted;
    for (int y = w.y; y < w.y + w.height; ++y)
        for (int x = w.x; x < w.x + w.width; ++x)
            if (to.marks[to.picture.index(x - part.x, y - part.y)])
                std::copy_n(from.pixel(x - window.drawn.x, y - window.drawn.y), 4,
                            to.picture.pixel(x - part.x, y - part.y));
}

/// Calls draw(begin, end) for the windows, at the same time if all of the model may be read: else
/// each tells what it meets.
void for_windows(const RenderJob& job, std::size_t n,
                 const std::function<void(std::size_t, std::size_t)>& draw) {
    if (job.reads->whole()) return parallel_blocks(n, kWindowGrain, draw);
    if (n > 0) draw(0, n);
}

/// Pixels about one that its own look at: openness is filtered over the samples about a sample.
int reach_of(const RenderJob& job) {
    static_assert(kOpennessReach <= SampleMask::kSide);
    return job.wants("ao") || job.config.ao ? 1 : 0;
}

/// What lies about samples: the plain frame's surface.
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
    const int reach = reach_of(job);
    const SampleMask drawn = reach > 0 ? marked.grown() : marked;
    const CoarsePlanes about = planes_around(frames.plain);
    const CoarsePlanes* around = frames.plain.buffer.has(kNormalChannel) ? &about : nullptr;
    const std::vector<SampleWindow> windows =
        job.traced ? sample_windows(marked, kTraced, reach, kTilesAlign)
                   : sample_windows(marked, kProjected, reach, kLanesAlign);
    if (windows.empty()) return;
    const SampleDrawing drawing(job, drawn, around, job.channels(aovs));
    std::vector<TraceCounts> light_counts(windows.size());
    for_windows(job, windows.size(), [&](std::size_t begin, std::size_t end) {
        RenderedFrame samples;
        for (std::size_t i = begin; i < end; ++i) {
            drawing.draw(windows[i].drawn, samples);
            light_counts[i] = samples.light_counts;
            for (EdgePicture& p : pictures)
                if (p.aov == "shaded") copy_marked(samples.shaded, windows[i], part.drawn, p);
                else
                    copy_marked(painted(job, p.aov, samples), windows[i], part.drawn, p);
        }
    });
    for (const TraceCounts& counts : light_counts) frames.plain.light_counts += counts;
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
