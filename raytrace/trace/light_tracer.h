#pragma once

#include "raytrace/surface_light.h"
#include "raytrace/trace/look.h"
#include "raytrace/trace/trace_scene.h"

#include <array>
#include <cstdint>
#include <optional>

namespace slim {

/// Places in the floats of a G-buffer, and of rays, are this exact (units of the model's frame).
inline constexpr float kPlaceRounding = 4e-7f;

/// A ground plane in scene coordinates.
struct SceneGround {
    Vec3f normal;
    float height, height_low;  ///< in two floats
    float clearance;           ///< rays that leave it start this far above

    SceneGround(const GroundPlane& plane, const TraceScene& scene);

    /// Where rays meet the upper side, infinite where they do not: from the second floats of the
    /// origins on for planes across an axis (all that --up makes); of tilted ones, whose normals
    /// are floats, as exact as a float of the scene.
    FloatV distance(const RayPacket& rays) const;
};

/// Where rays are sent for: the pixels of a block, after so many mirrors.
struct RaySite {
    const PixelBlock& block;
    TraceCounts& counts;
    int level = 0;

    RaySite behind_mirror() const { return {block, counts, level + 1}; }
    /// Keys of random numbers: a set of them for each level.
    std::uint64_t purpose() const { return static_cast<std::uint64_t>(level) << 16; }
};

/// Openness of some lanes' points.
struct KnownOpenness {
    FloatV open{1.0f};
    FloatV::mask_type known{false};
};

/// Sends rays from the surface. Random numbers are keyed by pixel and purpose.
class LightTracer {
public:
    LightTracer(const TraceScene& scene, const TraceLook& look);

    /// Share of the directions above the points in which nothing is within the distance. Of points
    /// that are seen from behind, inside something thinner than a tenth of the distance (its far
    /// side looks the other way), on their outer side: such are the backs of a rim's ragged discs
    /// and what cracks between discs show (notes/0002). So are, by their share, those that are seen
    /// through something `narrow` (narrow_backs.h; notes/0008), however deep they lie.
    FloatV open_share(const ShadePoints& at, const Openness& openness, const RaySite& site,
                      const FloatV& narrow = FloatV(0.0f)) const;

    /// Colour of the points, each of the material of its model.
    LanesOfVec color(const ShadePoints& at, const std::array<std::uint16_t, kLanes>& model,
                     const FloatV& open, const RaySite& site) const;

    /// Where rays meet the ground before `far`, if there is one.
    ShadePoints ground_points(const RayPacket& rays, const FloatV& far) const;

    /// The ground that a block's rays meet before `far`: premultiplied colour, opacity in `alpha`.
    /// `known` is its openness where that is found already.
    LanesOfVec ground_color(const RayPacket& rays, const FloatV& far, const RaySite& site,
                            FloatV& alpha, const KnownOpenness& known = {}) const;

private:
    /// Share of the rays that leave into the hemispheres about the normals, by the cosine, for
    /// which meets(RayPacket) is true.
    template <class Meets>
    FloatV share_above(const ShadePoints& at, const FloatV& far, int samples, const RaySite& site,
                       Meets&& meets) const;
    FloatV free_share(const ShadePoints& at, const FloatV& far, int samples,
                      const RaySite& site) const;
    /// Share of rays that first meet, before `far`, the far side of something thin: a surface whose
    /// outward normal is more than 120 degrees from the points' own, or one seen from its front,
    /// as by the back of a disc that overhangs an edge.
    FloatV share_of_far_side(const ShadePoints& at, const FloatV& far, int samples,
                             const RaySite& site) const;
    /// open_share if the look asks for it, else 1.
    FloatV openness(const ShadePoints& at, const RaySite& site) const;
    FloatV::mask_type unblocked(const ShadePoints& at, const FloatV::mask_type& lit,
                                const IncidentLight& light, TraceCounts& counts) const;
    LanesOfVec lit(const ShadePoints& at, const Material& material, const FloatV& open,
                   const RaySite& site) const;
    LanesOfVec mirrored(const ShadePoints& at, const RaySite& site) const;
    LanesOfVec background(const LanesOfVec& direction) const;
    FloatV shadow_alpha(const ShadePoints& at, const FloatV& open, const RaySite& site) const;

    const TraceScene& scene_;
    const TraceLook& look_;
    SceneRig rig_;
    std::optional<SceneGround> ground_;
};

}  // namespace slim
