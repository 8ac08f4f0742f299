#pragma once

#include "raytrace/trace/blend_hits.h"
#include "raytrace/trace/first_hits.h"
#include "raytrace/trace/ray_packet.h"
#include "raytrace/trace/trace_model.h"
#include "slim/base/bbox.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// What rays cost. Counts are of lanes with a ray (rays), of packets (nodes) or of all their lanes
/// (tests).
struct TraceCounts {
    std::uint64_t rays = 0;
    std::uint64_t nodes_visited = 0;  ///< boxes tested
    std::uint64_t root_tests = 0;
    std::uint64_t distance_tests = 0;

    TraceCounts& operator+=(const TraceCounts& b);
};

/// What a packet hits: the blended surface.
struct SurfaceHits {
    FloatV t{kFar};  ///< from the rays' origins, scene units; infinite without a hit
    FloatV first_t{kFar}, first_t_low{0.0f};  ///< of q^; what its float lacks
    LanesOfVec point{Vec3f{}}, point_low{Vec3f{}};  ///< scene coordinates; what their floats lack
    LanesOfVec normal{Vec3f{}};                     ///< unit, outwards
    FloatV clearance{0.0f};  ///< a ray that leaves the surface starts this far off it
    std::array<std::uint32_t, kLanes> model{}, record{};  ///< of the surfel that set q^
    BlendLanes sums;

    FloatV::mask_type hit() const { return t < kFar; }
    /// Some lanes become those of another packet.
    void take(const FloatV::mask_type& lanes, const SurfaceHits& from, Derivatives wanted);
};

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
