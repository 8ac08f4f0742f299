#pragma once

#include "pipeline/render_job.h"
#include "pipeline/stage.h"

#include <chrono>

namespace slim {

/// The size at which ranges, legends and contour spacing of a picture are decided: at most 1000
/// pixels on the longer side.
PictureSize reference_size(const PictureSize& size);

/// A pixel of the picture in pixels of that frame.
double reference_scale(const PictureSize& size);

/// What reference pictures are drawn for: ranges, legends and contour spacing; none if it is empty.
std::vector<std::string> reference_aovs(const RenderJob& job);

/// A camera of same_range.
Camera camera_of_range(const RenderJob& job, const std::string& name);

/// Decides what holds for the picture as a whole: ranges, legends and their places, contour lines.
void choose_looks(RenderJob& job);

/// Finds the lines of the whole picture in bands that take at most about 384 MiB, by the bytes of a pixel.
std::vector<FeatureLine> find_lines(const RenderJob& job, std::uint64_t pixel_bytes, StageContext& context);

double milliseconds_since(std::chrono::steady_clock::time_point start);

/// Draws the frames of a part, as often as the job says, and what derives from them.
Frames draw_frames(const RenderJob& job, const PicturePart& part, StageContext& context);

}  // namespace slim
