#include "pipeline/render/render_contours.h"

#include "raytrace/lines/height_svg.h"
#include "raytrace/lines/label_place.h"
#include "raytrace/scale_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <system_error>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// Heights of a box in the world.
std::array<double, 2> heights_of(const Bbox& box, const Relief& relief) {
    double low = relief.base, high = relief.base;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto up = static_cast<double>(relief.axes[1][axis]);
        low += std::min(up * box.lo[axis], up * box.hi[axis]);
        high += std::max(up * box.lo[axis], up * box.hi[axis]);
    }
    return {low, high};
}

/// Digits behind the point that tell heights of a range apart.
int digits_of(double range) {
    return range > 0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(range))), 0, 15) : 3;
}

/// An earlier drawing beside a picture that has none would be taken for its own.
void remove_old(const fs::path& drawing) {
    std::error_code ignored;
    fs::remove(drawing, ignored);
}

/// `better`: the spacing that auto chooses; 0: none.
void warn_of_no_lines(const RenderJob& job, double better, Reporter& reporter) {
    const ContourLevels& c = job.contours;
    const std::string unit = job.config.unit.empty() ? "units" : job.config.unit;
    const int digits = digits_of(c.high - c.low);
    reporter.warn(fmt::format(
        "contours: no line is drawn: the heights {}, {:.{}f} to {:.{}f} {}, have none every {:g} "
        "{}{}",
        job.n_frames > 1 ? "of the model" : "seen", c.low, digits, c.high, digits, unit, c.spacing,
        unit,
        better > 0 ? fmt::format("; every {:g} {}, as auto chooses, there are about 20", better,
                                 unit)
                   : ""));
}

}  // namespace

void choose_contours(RenderJob& job, const RenderedFrame& reference, Reporter& reporter) {
    Relief& relief = job.shadings.relief;
    const GBuffer& b = reference.buffer;
    if (std::find(b.hit.begin(), b.hit.end(), 1) == b.hit.end()) return;
    const auto [most_low, most_high] = height_span(b, relief, 2);
    const double better = contour_spacing(most_low, most_high);
    if (job.config.contours == "auto") relief.spacing = better;
    auto [low, high] = height_span(b, relief, 0);
    if (job.n_frames > 1) {  // other pictures may see more than the first
        const auto [box_low, box_high] = heights_of(job.header().bounds, relief);
        low = std::min(low, box_low), high = std::max(high, box_high);
    }
    job.contours = contour_levels(relief, low, high);
    if (job.contours.lines > 0 || !(relief.spacing > 0)) return;
    relief.spacing = 0;
    if (job.share.number > 1) return;
    warn_of_no_lines(job, better, reporter);
    if (job.n_frames == 1) remove_old(job.plan.contours_svg());
}

std::vector<HeightLabel> contour_heights(const RenderJob& job, const AovLook& look,
                                         const RenderedFrame& reference) {
    const Relief& relief = job.shadings.relief;
    if (job.n_frames > 1 || !(relief.spacing > 0)) return {};
    LabelSheet sheet{job.size.width, job.size.height, job.config.unit, {}};
    if (look.key && look.words_fit && job.config.legend)
        sheet.taken.push_back(key_box(*look.key, look.place, job.size.width, job.size.height));
    if (job.config.scale_bar)
        sheet.taken.push_back(scale_bar_box({job.size.width / job.camera.width, job.config.unit},
                                            job.size.width, job.size.height, look.bar_place));
    const LineScene view{.buffer = reference.buffer, .view = reference.pixels};
    std::vector<HeightLabel> labels = place_height_labels(view, relief, sheet);
    if (!labels.empty()) return labels;
    // No heavy line has room for its height, or there is none: then any line's.
    Relief every_line = relief;
    every_line.index_every = 1;
    return place_height_labels(view, every_line, sheet);
}

float contour_width(int picture_height) {
    return std::max(1.0f, static_cast<float>(picture_height) / 1000);
}

bool writes_contours(const RenderJob& job) {
    return job.n_frames == 1 && job.share.number <= 1 && job.shadings.relief.spacing > 0 &&
           contains(job.plan.drawn, "hillshade");
}

ContourDrawing::ContourDrawing(const RenderJob& job)
    : job_(job), search_(job.shadings.relief, job.shadings.relief.spacing) {}

void ContourDrawing::add(const RenderedFrame& frame, const PicturePart& part) {
    const PixelWindow inside = part.inside();
    const SceneRows rows{frame.window.y, frame.size.height, inside.y, inside.y + inside.height};
    search_.add({.buffer = frame.buffer, .view = frame.pixels, .rows = rows}, frame.window.x);
}

std::optional<NamedText> ContourDrawing::finish(const PixelWindow& window, Reporter& reporter) {
    const Relief& relief = job_.shadings.relief;
    const fs::path path = job_.plan.contours_svg();
    const auto lines = search_.finish();
    if (!lines) {
        reporter.warn(fmt::format(
            "{}: not written: lines every {:g} {} are of more than {:.0f} million pieces, one "
            "a pixel; wider ones, or a smaller size, give less",
            path.string(), relief.spacing, job_.config.unit.empty() ? "units" : job_.config.unit,
            HeightLineSearch::kMostPieces / 1e6));
        remove_old(path);
        return std::nullopt;
    }
    return NamedText{path, height_svg(*lines, job_.looks.at("hillshade").heights,
                                      relief.index_every, contour_width(job_.size.height), window,
                                      svg_scale(job_.config, job_.camera, job_.size))};
}

}  // namespace slim
