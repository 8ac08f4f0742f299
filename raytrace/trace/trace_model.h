#pragma once

#include "raytrace/intersect/sharp_kernel.h"
#include "raytrace/scene_frame.h"
#include "raytrace/trace/bvh.h"
#include "raytrace/trace/model_place.h"
#include "slim/blend/leaf_hessians.h"
#include "slim/model/rim.h"
#include "slim/model/surfel_tree.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace slim {

/// A surfel ready for rays from anywhere: floats, the scene's axes, places and lengths of the
/// model's frame; two cache lines.
struct alignas(64) TraceRecord {
    std::array<float, 3> center;      ///< coordinates of the model's frame
    std::array<float, 3> center_low;  ///< what they lack of the exact ones
    float radius, inv_radius;         ///< units of it
    std::array<float, 3> u_axis, v_axis, normal;
    std::array<float, 10> a;
    std::uint32_t node;
    std::uint32_t sharp = kNotSharp;  ///< entry in TraceModel::sharp
    PackedRims rims;
    std::uint8_t degree;  ///< 1 to 3; a disc counts as 1
    float clearance;      ///< max(2 eps, 1e-4 rho), the same units (NUMERICS 7.3)

    static constexpr std::uint32_t kNotSharp = 0xffffffffu;
};
static_assert(sizeof(TraceRecord) == 128);

/// The leaves of a model in the order of a tree of boxes over what stage 1 can hit: their surface
/// in the ball shrunken by kHitTrim. The same tree with the boxes of the whole balls finds
/// supporters.
struct TraceModel {
    ModelPlace place;         ///< of its frame in the scene's
    SceneFrame frame;         ///< its frame, in the job's
    Bvh bvh;                  ///< `order` is empty: record i is item i
    std::vector<BoxF> balls;  ///< of each node
    std::vector<TraceRecord> records;
    std::unique_ptr<LeafHessians> hessians;  ///< of its tree; nothing is known before it is asked
    std::vector<SharpRecord> sharp;  ///< sheets in the scene's axes; fields of a view unused
    std::uint64_t loose_hidden = 0;
    bool is_sharp = false;  ///< the model has sharp surfels: the close gate (Gate in slim/blend)

    const HeightHessian* hessian_of(const TraceRecord& r) const {
        return hessians->of(r.node);
    }
};

/// What stage 1 can hit of a surfel; a sharp one reaches anywhere in its shrunken ball.
BoxF hit_box(const TraceRecord& r);

/// Decodes a model's leaves for rays; `offset` is where its file's frame lies in the job's. Loose
/// leaves only if asked. The tree's arrays must outlive the model.
///
/// cost  O(n log n) for n leaves, in parallel; 220 bytes a leaf
TraceModel trace_model(const SurfelTree& tree, const SceneFrame& scene, const ModelPlace& place,
                       const Vec3d& offset, bool loose);

}  // namespace slim
