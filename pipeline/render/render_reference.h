#pragma once

#include "pipeline/render/render_job.h"
#include "slim/base/reporter.h"

namespace slim {

/// Decides what holds for the picture as a whole: ranges, legends and their places, contour lines;
/// by a frame of the view at no more than 1000 pixels on its longer side.
void choose_looks(RenderJob& job, Reporter& reporter);

}  // namespace slim
