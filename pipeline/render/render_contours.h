#pragma once

#include "pipeline/render/render_job.h"
#include "raytrace/lines/height_line.h"
#include "slim/base/reporter.h"

#include <optional>
#include <span>
#include <vector>

namespace slim {

/// Chooses the spacing of a relief's contour lines where that is auto, and counts those among the
/// heights of a frame of the whole picture, of a film among those of the models' bounds. If there
/// are none, the relief has none, as with --contours none, and a warning says so.
void choose_contours(RenderJob& job, const RenderedFrame& reference, Reporter& reporter);

/// Heights along the index contours of a relief, along any lines if none of these has one, and
/// their places, by a frame of the whole picture (which may be smaller). None in films: they would
/// jump from picture to picture.
std::vector<HeightLabel> contour_heights(const RenderJob& job, const AovLook& look,
                                         const RenderedFrame& reference);

/// Width of a contour line in a picture of that height, pixels; index contours are twice as wide.
float contour_width(int picture_height);

/// Whether this run writes the contour lines as a drawing: of a relief of one picture; of shares
/// the first does.
bool writes_contours(const RenderJob& job);

/// Contour lines of the picture or a part of it, in frames of its own size.
class ContourDrawing {
public:
    explicit ContourDrawing(const RenderJob& job);

    /// What is wanted of a frame, band by band from the top. cost O(pixels)
    void add(const RenderedFrame& frame, const PicturePart& part);
    /// x.contours.svg, of the window; none, with a warning, where the lines are too many for one.
    std::optional<NamedText> finish(const PixelWindow& window, Reporter& reporter);

private:
    const RenderJob& job_;
    HeightLineSearch search_;
};

}  // namespace slim
