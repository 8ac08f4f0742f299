#pragma once

#include "pipeline/render_job.h"
#include "pipeline/stage.h"

namespace slim {

/// Decides what holds for the picture as a whole: ranges, legends and their places, contour lines.
void choose_looks(RenderJob& job);

/// Draws the frames of a part, as often as the job says, and what derives from them.
Frames draw_frames(const RenderJob& job, const PicturePart& part, StageContext& context);

}  // namespace slim
