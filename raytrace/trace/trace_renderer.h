#pragma once

#include "raytrace/frame.h"
#include "raytrace/renderer.h"
#include "raytrace/sample_mask.h"
#include "raytrace/trace/trace_scene.h"

#include <array>
#include <cstdint>
#include <vector>

namespace slim {

/// What is known of each traced pixel besides the G-buffer.
struct TracedPlanes {
    std::vector<float> clearance;  ///< SurfaceHits::clearance
    std::vector<std::uint16_t>
        model;  ///< number of the model that is hit; empty if the scene has but one
    /// What the floats of GBuffer::position lack; empty unless the scene is wide.
    std::array<std::vector<float>, 3> position_low;
};

/// Draws a scene by a ray through each pixel's centre: the same surface as render_forward at lod 0
/// and as render_brute, of several models the nearest. Single precision relative to each surfel,
/// lanes over rays; the same bytes for any number of threads, and for a window those of the whole
/// picture. lod_px and loose are not used: the scene was made with them.
///
/// nodes and surfel_id are those of the model that is hit; unblended pixels keep q^, as in forward
/// projection. `only`, if given: the window is of a picture of twice the size, of which these
/// samples are drawn.
/// throws  ConfigError for the camera, the size or the window
/// cost    O(pixels x log surfels)
RenderStats render_traced(const TraceScene& scene, const RenderRequest& request, GBuffer& out,
                          TracedPlanes* planes = nullptr, const SampleMask* only = nullptr);

}  // namespace slim
