#pragma once

#include "raytrace/picture.h"
#include "raytrace/surface_light.h"
#include "raytrace/trace/look.h"
#include "raytrace/trace/trace_renderer.h"

#include <optional>
#include <span>
#include <vector>

namespace slim {

/// What was seen, and the scene that sends rays from there.
struct TracedSurface {
    const TraceScene& scene;
    SurfacePlanes planes;
    const TracedPlanes& traced;
    std::span<const float> narrow = {};  ///< narrow_backs, for openness_plane; empty: none
};

/// Openness of every hit, 1 where nothing is near; 0 elsewhere. The ground is near, too, where
/// there is one. Filtered (openness_filter.h): pixels kOpennessReach inside a window are the whole
/// picture's. Rows in parallel.
std::vector<float> openness_plane(const TracedSurface& surface, const Openness& openness,
                                  const std::optional<GroundPlane>& ground, TraceCounts& counts);

/// The same of the ground, where a pixel without a hit shows it.
std::vector<float> ground_openness_plane(const TracedSurface& surface, const Openness& openness,
                                         const GroundPlane& ground, TraceCounts& counts);

/// Both, empty where they are not wanted.
struct OpenPlanes {
    std::span<const float> surface = {}, ground = {};
};

/// Shades rows of a traced frame: light with shadows, mirror images, the ground. `open` is
/// openness_plane and ground_openness_plane if the look has openness, else empty; a ground without
/// is found pixel by pixel.
///
/// returns  premultiplied linear Rec.709
/// cost     a shadow ray for each hit, light and sample; what the look leaves out costs nothing.
/// Rows in parallel.
Picture light_rows(const TracedSurface& surface, const TraceLook& look, const OpenPlanes& open,
                   const RowRange& rows, TraceCounts& counts);

}  // namespace slim
