#pragma once

#include "raytrace/trace/first_hits.h"
#include "raytrace/trace/ray_packet.h"
#include "raytrace/trace/surface_hits.h"
#include "raytrace/trace/trace_model.h"
#include "slim/base/bbox.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// A model and where its frame lies in the job's.
struct ScenePart {
    const SurfelTree* tree;
    Vec3d offset;
};

/// Models made ready for rays.
class TraceScene {
public:
    /// cost  trace_model of each part
    TraceScene(std::span<const ScenePart> parts, bool loose);

    const SceneFrame& frame() const { return frame_; }
    const std::vector<TraceModel>& models() const { return models_; }
    const std::vector<ScenePart>& parts() const { return parts_; }
    /// Every surfel's ball lies in it; frame of the job.
    const Bbox& bounds() const { return bounds_; }
    std::size_t n_surfels() const;
    /// Some models have a frame of their own: floats of scene coordinates are not enough for them.
    bool is_wide() const;

    /// Stage 1: the first hits on the shrunken balls (Ohtake 2005, sec. 3), front to back; of
    /// several models the nearest, of equally near ones the first. `model` gets the number of the
    /// winner's.
    FirstHits first_hits(const RayPacket& rays, std::array<std::uint32_t, kLanes>& model,
                         TraceCounts& counts) const;

    /// Both stages: what is seen along the rays. Lanes that have no weight in stage 2 keep q^
    /// (sums.weight is 0 there). clean_outlines: as in RenderRequest.
    SurfaceHits surface(const RayPacket& rays, Derivatives wanted, TraceCounts& counts,
                        bool clean_outlines = false) const;

    /// Lanes whose ray meets no surface up to its far end: stage 1 only, any hit ends a ray.
    FloatV::mask_type unblocked(const RayPacket& rays, TraceCounts& counts) const;

private:
    /// As surface, whether or not q^ is outvoted; find_passing: sums.passing says that.
    SurfaceHits surface_at_first(const RayPacket& rays, Derivatives wanted, TraceCounts& counts,
                                 bool find_passing) const;

    std::vector<ScenePart> parts_;
    std::vector<TraceModel> models_;
    SceneFrame frame_;
    Bbox bounds_;
};

}  // namespace slim
