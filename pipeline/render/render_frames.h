#pragma once

#include "pipeline/render/render_contours.h"
#include "pipeline/render/render_job.h"
#include "pipeline/stage.h"
#include "raytrace/project/forward_picture.h"

#include <chrono>
#include <optional>

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

/// Samples of some pixels of a part of the picture, ready to be drawn window by window.
class SampleDrawing {
public:
    /// `only` are the pixels; `around`, if given, is what lies about their samples. All outlive
    /// this.
    SampleDrawing(const RenderJob& job, const SampleMask& only, const CoarsePlanes* around,
                  Channels wanted);

    /// Draws the samples of a window of the picture, shades them and means them, pixel by pixel;
    /// pixels without samples are empty. Several windows may be drawn at the same time.
    void draw(const PixelWindow& window, RenderedFrame& frame) const;

private:
    const RenderJob& job_;
    const SampleMask& only_;
    const CoarsePlanes* around_;
    Channels wanted_;
    std::optional<ForwardPicture> ready_;  ///< of forward projection
};

/// Draws the frames of a part, as often as the job says, and what derives from them.
Frames draw_frames(const RenderJob& job, const PicturePart& part, StageContext& context);

}  // namespace slim
