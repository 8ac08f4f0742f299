#pragma once

#include "raytrace/trace/first_hits.h"
#include "raytrace/trace/trace_model.h"

#include <embree3/rtcore.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace slim {

static_assert(kLanes == 16 || kLanes == 8 || kLanes == 4, "Embree has packets of these sizes");

inline RTCBuildQuality embree_quality(const std::string& name) {
    if (name == "low") return RTC_BUILD_QUALITY_LOW;
    if (name == "medium") return RTC_BUILD_QUALITY_MEDIUM;
    if (name == "high") return RTC_BUILD_QUALITY_HIGH;
    throw std::runtime_error("QUALITY is low, medium or high, not " + name);
}

/// A packet of kLanes rays as Embree has it.
struct Packet {
    static constexpr std::size_t kSize = kLanes == 4 ? 0 : kLanes == 8 ? 1 : 2;
    using RayHit = std::tuple_element_t<kSize, std::tuple<RTCRayHit4, RTCRayHit8, RTCRayHit16>>;
    using Ray = std::tuple_element_t<kSize, std::tuple<RTCRay4, RTCRay8, RTCRay16>>;
    static constexpr auto intersect =
        std::get<kSize>(std::tuple(&rtcIntersect4, &rtcIntersect8, &rtcIntersect16));
    static constexpr auto occluded =
        std::get<kSize>(std::tuple(&rtcOccluded4, &rtcOccluded8, &rtcOccluded16));
};

/// Surfels as Embree's user geometry; the model and its boxes must outlive it.
class EmbreeSurfels {
public:
    EmbreeSurfels(const TraceModel& model, const std::vector<BoxF>& boxes, int n_threads,
                  RTCBuildQuality quality)
        : model_(model),
          boxes_(boxes),
          device_(rtcNewDevice(("threads=" + std::to_string(n_threads)).c_str())),
          scene_(rtcNewScene(device_)) {
        rtcSetSceneBuildQuality(scene_, quality);
        RTCGeometry surfels = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryBuildQuality(surfels, quality);
        rtcSetGeometryUserPrimitiveCount(surfels, static_cast<unsigned>(boxes.size()));
        rtcSetGeometryUserData(surfels, this);
        rtcSetGeometryBoundsFunction(surfels, bounds, nullptr);
        rtcSetGeometryIntersectFunction(surfels, intersect);
        rtcSetGeometryOccludedFunction(surfels, occluded);
        rtcCommitGeometry(surfels);
        rtcAttachGeometry(scene_, surfels);
        rtcReleaseGeometry(surfels);
        rtcCommitScene(scene_);
        if (rtcGetDeviceError(device_) != RTC_ERROR_NONE)
            throw std::runtime_error("Embree: no scene");
    }
    ~EmbreeSurfels() { rtcReleaseScene(scene_), rtcReleaseDevice(device_); }
    EmbreeSurfels(const EmbreeSurfels&) = delete;
    EmbreeSurfels& operator=(const EmbreeSurfels&) = delete;

    FirstHits first_hits(const RayPacket& rays) const {
        FirstHits hits;
        hits.t = rays.far, hits.gradient = LanesOfVec(Vec3f{});
        Search search{{}, rays, &hits, nullptr};
        begin(search);
        Packet::RayHit r;
        alignas(64) int valid[kLanes];
        fill(rays, r.ray, valid);
        for (unsigned& id : r.hit.geomID) id = RTC_INVALID_GEOMETRY_ID;
        Packet::intersect(valid, scene_, &search.context, &r);
        hits.t = select<FloatV>(hits.t < rays.far, hits.t, FloatV(kFar));
        return hits;
    }

    FloatV::mask_type unblocked(const RayPacket& rays) const {
        FloatV end = rays.far;
        Search search{{}, rays, nullptr, &end};
        begin(search);
        Packet::Ray r;
        alignas(64) int valid[kLanes];
        fill(rays, r, valid);
        Packet::occluded(valid, scene_, &search.context, &r);
        return rays.active() && end >= 0.0f;
    }

private:
    /// What a packet's callbacks work on.
    struct Search {
        RTCIntersectContext context;  // first: Embree hands its address on
        const RayPacket& rays;
        FirstHits* hits;
        FloatV* end;
    };

    static void begin(Search& search) {
        rtcInitIntersectContext(&search.context);
        search.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    }

    template <class Ray>
    static void fill(const RayPacket& rays, Ray& r, int* valid) {
        const auto copy = [](const FloatV& v, float* to) { v.copy_to(to, stdx::element_aligned); };
        copy(rays.origin.x, r.org_x), copy(rays.origin.y, r.org_y), copy(rays.origin.z, r.org_z);
        copy(rays.direction.x, r.dir_x), copy(rays.direction.y, r.dir_y),
            copy(rays.direction.z, r.dir_z);
        copy(rays.far, r.tfar);
        copy(FloatV(0.0f), r.tnear), copy(FloatV(0.0f), r.time);
        const auto on = rays.active();
        for (std::size_t k = 0; k < kLanes; ++k)
            r.mask[k] = ~0u, r.id[k] = r.flags[k] = 0, valid[k] = on[k] ? -1 : 0;
    }

    static void bounds(const RTCBoundsFunctionArguments* a) {
        const BoxF& b = static_cast<const EmbreeSurfels*>(a->geometryUserPtr)->boxes_[a->primID];
        *a->bounds_o = {b.lo.x, b.lo.y, b.lo.z, 0, b.hi.x, b.hi.y, b.hi.z, 0};
    }

    static FloatV::mask_type lanes_of(const int* valid) {
        const stdx::fixed_size_simd<int, kLanes> v(valid, stdx::element_aligned);
        return FloatV([&](auto k) { return static_cast<float>(v[k]); }) < 0.0f;
    }

    static void intersect(const RTCIntersectFunctionNArguments* a) {
        const auto& self = *static_cast<const EmbreeSurfels*>(a->geometryUserPtr);
        const auto& search = *reinterpret_cast<const Search*>(a->context);
        surfel_hits(self.model_, a->primID, search.rays, KeepNearest{*search.hits});
        float* tfar = &RTCRayN_tfar(RTCRayHitN_RayN(a->rayhit, a->N), a->N, 0);
        FloatV far(tfar, stdx::element_aligned);
        far = select<FloatV>(lanes_of(a->valid), stdx::min(far, search.hits->t), far);
        far.copy_to(tfar, stdx::element_aligned);
    }

    static void occluded(const RTCOccludedFunctionNArguments* a) {
        const auto& self = *static_cast<const EmbreeSurfels*>(a->geometryUserPtr);
        const auto& search = *reinterpret_cast<const Search*>(a->context);
        surfel_hits(self.model_, a->primID, search.rays, EndAtAny{*search.end});
        float* tfar = &RTCRayN_tfar(a->ray, a->N, 0);
        FloatV far(tfar, stdx::element_aligned);
        far = select<FloatV>(lanes_of(a->valid) && *search.end < 0.0f, FloatV(-kFar), far);
        far.copy_to(tfar, stdx::element_aligned);
    }

    const TraceModel& model_;
    const std::vector<BoxF>& boxes_;
    RTCDevice device_;
    RTCScene scene_;
};

}  // namespace slim
