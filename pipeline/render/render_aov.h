#pragma once

#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_config.h"
#include "pipeline/render/render_view.h"
#include "raytrace/frame.h"
#include "raytrace/picture.h"
#include "raytrace/renderer.h"
#include "raytrace/sample_mask.h"
#include "raytrace/trace/trace_renderer.h"
#include "slim/base/bbox.h"

#include <span>
#include <string>
#include <vector>

namespace slim {

/// One rendered frame, or the part of one that its buffer holds, and what derives from it.
struct RenderedFrame {
    PictureSize size;    ///< of the whole
    PixelWindow window;  ///< the buffer's part of it
    PixelView pixels;    ///< of the whole
    ShadeView view;      ///< of the part
    GBuffer buffer;
    std::vector<float> truth_distance;  ///< empty unless asked for; model units, 0 without a hit
    TracedPlanes traced;                ///< of a frame drawn by rays
    std::vector<double> diagonals;      ///< L of each model, of a frame that
                                        ///< several are drawn in; else empty
    std::vector<float> open;            ///< ambient openness, 0 to 1; empty unless asked for
    std::vector<float> ground_open;     ///< the same of the ground, where it is seen
    std::vector<Vec3f> tints;           ///< the scan's colours at the hits, of a material that has
                                        ///< them; else empty
    TraceCounts light_counts;           ///< rays for light
    const SampleMask* only = nullptr;   ///< what of the buffer was drawn, if not all
    Picture shaded;                     ///< the part at the picture's size; empty unless asked for
};

/// Signed distance of every hit to the shape of config.truth_shape (its origin at config.offset in
/// the world), positive outside. Parallel over pixels. Throws ConfigError for an unknown shape or a
/// bad offset. 0 where no nearest point is known (nearest_point), counted in `n_unknown`. Cost:
/// about six evaluations of the shape per hit.
std::vector<float> truth_distances(const RenderConfig& config, const Vec3d& model_origin,
                                   const GBuffer& buffer, std::uint64_t* n_unknown = nullptr);

/// What an AOV paints as a map: a plane of the frame, or the magnitudes of one whose sign is
/// arbitrary.
struct MapValues {
    std::span<const float> plane;
    std::vector<float> magnitudes;
    std::span<const float> span() const {
        return magnitudes.empty() ? plane : std::span<const float>(magnitudes);
    }
};
MapValues map_values(const std::string& aov, const RenderedFrame& frame);

struct AovLook;
struct ShadingInputs;

/// Draws an AOV of a frame's part, over transparent; a frame larger than `size`, the whole
/// picture's, is averaged.
Picture draw_aov(const RenderConfig& config, const std::string& aov, const AovLook& look,
                 const ShadingInputs& shadings, const RenderedFrame& frame, const Bbox& bounds,
                 const PictureSize& size);

}  // namespace slim
