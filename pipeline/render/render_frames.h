#pragma once

#include "pipeline/render/render_contours.h"
#include "pipeline/render/render_job.h"
#include "pipeline/stage.h"

#include <chrono>

namespace slim {

/// A frame of that size, of the window alone: projection and what derives from it; `lod` in pixels
/// of the frame.
RenderStats draw_buffer(const RenderJob& job, const PictureSize& size, const PixelWindow& window,
                        double lod, Channels wanted, RenderedFrame& frame);

/// Finds the lines of the whole picture in bands that take at most about 384 MiB, by the bytes of a
/// pixel.
std::vector<FeatureLine> find_lines(const RenderJob& job, std::uint64_t pixel_bytes,
                                    StageContext& context);

/// Shows the contour lines of a part of the picture, in frames of its own size drawn for that.
void add_contours(const RenderJob& job, const PixelWindow& window, StageContext& context,
                  ContourDrawing& drawing);

double milliseconds_since(std::chrono::steady_clock::time_point start);

/// Draws samples of a window of the picture, shades them and means them, pixel by pixel; pixels
/// without samples are empty. `around`, which must outlive the frame, is what lies about them.
void draw_samples(const RenderJob& job, const PixelWindow& window, const SampleMask& only,
                  const CoarsePlanes* around, Channels wanted, RenderedFrame& frame);

/// Draws the frames of a part, as often as the job says, and what derives from them.
Frames draw_frames(const RenderJob& job, const PicturePart& part, StageContext& context);

}  // namespace slim
