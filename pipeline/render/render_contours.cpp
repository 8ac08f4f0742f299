#include "pipeline/render/render_contours.h"

#include "raytrace/lines/height_svg.h"
#include "raytrace/lines/label_place.h"
#include "raytrace/scale_bar.h"

#include <algorithm>

namespace slim {

std::vector<HeightLabel> contour_heights(const RenderJob& job, const AovLook& look,
                                         const RenderedFrame& reference) {
    const Relief& relief = job.shadings.relief;
    if (job.n_frames > 1 || !(relief.spacing > 0)) return {};
    LabelSheet sheet{job.size.width, job.size.height, job.config.unit, {}};
    if (look.key && job.config.legend)
        sheet.taken.push_back(key_box(*look.key, look.place, job.size.width, job.size.height));
    if (job.config.scale_bar)
        sheet.taken.push_back(scale_bar_box({job.size.width / job.camera.width, job.config.unit},
                                            job.size.width, job.size.height));
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

NamedText ContourDrawing::finish(const PixelWindow& window) {
    return {job_.plan.contours_svg(),
            height_svg(search_.finish(), job_.looks.at("hillshade").heights,
                       job_.shadings.relief.index_every, contour_width(job_.size.height), window)};
}

}  // namespace slim
