#include "raytrace/trace/trace_model.h"

#include "slim/base/parallel.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kGrain = 1024;
/// Boxes are wider by this (units of the frame), for the rounding of rays and boxes.
constexpr float kBoxMargin = 1e-6f;

std::array<float, 3> floats(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// What all sheets have in common with a TraceRecord.
template <class Record>
void fill_sheet(const Surfel& s, std::size_t sheet, double radius, Record& r) {
    r.radius = static_cast<float>(radius), r.inv_radius = static_cast<float>(1 / radius);
    const Frame<double>& frame = s.sheet_frame(sheet);
    r.u_axis = floats(frame.u_axis), r.v_axis = floats(frame.v_axis);
    r.normal = floats(frame.normal);
    for (std::size_t k = 0; k < r.a.size(); ++k)
        r.a[k] = static_cast<float>(s.sheet_polynomial(sheet).a[k]);
}

SharpRecord sharp_of(const Surfel& s, double radius) {
    SharpRecord out{};
    out.n_sheets = s.n_sheets(), out.outer = s.sharp->outer, out.inner = s.sharp->inner;
    for (std::size_t i = 0; i < out.n_sheets; ++i) fill_sheet(s, i, radius, out.sheet[i]);
    return out;
}

/// The least degree whose kernels see all of a surfel's coefficients.
std::uint8_t degree_of(const Surfel& s) {
    const auto any = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = 0; i < s.n_sheets(); ++i)
            for (std::size_t k = begin; k < end; ++k)
                if (s.sheet_polynomial(i).a[k] != 0) return true;
        return false;
    };
    return any(6, 10) ? 3 : any(1, 6) ? 2 : 1;
}

TraceRecord record_of(const Surfel& s, const TreeNode& node, std::uint32_t id, const Vec3d& center,
                      double unit) {
    TraceRecord r{};
    r.center = floats(center);
    r.center_low = floats(center - Vec3d{r.center[0], r.center[1], r.center[2]});
    const double radius = s.support_radius / unit;
    fill_sheet(s, 0, radius, r);
    r.node = id, r.rims = s.rims;
    r.degree = degree_of(s);
    r.clearance = static_cast<float>(std::max(2 * node.fit_error / unit, 1e-4 * radius));
    return r;
}

/// Reach of the surface w = P(u, v) along the normal, within `share` of the ball (units of rho).
struct Slab {
    float low, high;
    Slab(const std::array<float, 10>& a, float share) {
        const float mean = 0.5f * (a[3] + a[5]), half = 0.5f * (a[3] - a[5]);
        const float spread = std::sqrt(half * half + 0.25f * a[4] * a[4]);
        // The largest u^2 v on the unit circle is 2 / sqrt(27).
        const float third =
            std::abs(a[6]) + std::abs(a[9]) + 0.385f * (std::abs(a[7]) + std::abs(a[8]));
        const float tilt = std::sqrt(a[1] * a[1] + a[2] * a[2]);
        const float either = share * (tilt + share * share * third) + 1e-4f;
        low = std::clamp(a[0] - either + share * share * std::min(0.0f, mean - spread), -share,
                         share);
        high = std::clamp(a[0] + either + share * share * std::max(0.0f, mean + spread), -share,
                          share);
    }
    /// How far the slab within the ball of radius `share` reaches in the unit direction whose part
    /// along the normal is n.
    float reach(float n, float share) const {
        if (n * share > high) return rest(n, high, share);
        if (n * share < low) return rest(n, low, share);
        return share;
    }

private:
    static float rest(float n, float at, float share) {
        const float across = std::sqrt(std::max(0.0f, 1 - n * n));
        return n * at + across * std::sqrt(std::max(0.0f, share * share - at * at));
    }
};

BoxF ball_box(const TraceRecord& r, float share) {
    const float reach = share * r.radius + kBoxMargin;
    const Vec3f c{r.center[0], r.center[1], r.center[2]}, e{reach, reach, reach};
    return {c - e, c + e};
}

std::vector<std::uint32_t> wanted_leaves(const SurfelTree& tree, bool loose,
                                         std::uint64_t& hidden) {
    std::vector<std::uint32_t> leaves;
    for (std::uint32_t i = 0; i < tree.n_nodes(); ++i) {
        const TreeNode& node = tree.node(i);
        if (!node.is_leaf()) continue;
        if (loose || !node.is_loose())
            leaves.push_back(i);
        else
            ++hidden;
    }
    return leaves;
}

/// Sharp surfels are few: one by one, in order, after all others are decoded.
void add_sharp(const SurfelTree& tree, const SceneFrame& frame, TraceModel& model) {
    if (tree.sharp().empty()) return;
    for (TraceRecord& r : model.records) {
        const Surfel s = tree.surfel(r.node);
        if (!s.sharp) continue;
        r.sharp = static_cast<std::uint32_t>(model.sharp.size());
        model.sharp.push_back(sharp_of(s, s.support_radius / frame.unit));
    }
}

/// Puts the records in the order of the tree's leaves.
void reorder(TraceModel& model) {
    std::vector<TraceRecord> sorted(model.records.size());
    parallel_blocks(sorted.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) sorted[i] = model.records[model.bvh.order[i]];
    });
    model.records.swap(sorted);
    model.bvh.order = {};
}

}  // namespace

BoxF hit_box(const TraceRecord& r) {
    constexpr auto share = static_cast<float>(kHitTrim);
    BoxF box = ball_box(r, share);
    if (r.sharp != TraceRecord::kNotSharp) return box;
    const Slab slab(r.a, share);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float n = r.normal[axis];
        box.hi[axis] = r.center[axis] + r.radius * slab.reach(n, share) + kBoxMargin;
        box.lo[axis] = r.center[axis] - r.radius * slab.reach(-n, share) - kBoxMargin;
    }
    return box;
}

TraceModel trace_model(const SurfelTree& tree, const SceneFrame& scene, const ModelPlace& place,
                       const Vec3d& offset, bool loose) {
    TraceModel model;
    model.place = place;
    model.hessians = std::make_unique<LeafHessians>(tree);
    const SceneFrame& frame = model.frame = place.frame(scene);
    model.is_sharp = !tree.sharp().empty();
    const auto leaves = wanted_leaves(tree, loose, model.loose_hidden);
    model.records.resize(leaves.size());
    std::vector<BoxF> cores(leaves.size()), balls(leaves.size());
    parallel_blocks(leaves.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Surfel s = tree.surfel(leaves[i]);
            const Vec3d center = (s.center + offset - frame.middle) / frame.unit;
            model.records[i] = record_of(s, tree.node(leaves[i]), leaves[i], center, frame.unit);
        }
    });
    add_sharp(tree, frame, model);
    parallel_blocks(leaves.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            cores[i] = hit_box(model.records[i]), balls[i] = ball_box(model.records[i], 1);
    });
    model.bvh = build_bvh(cores);
    model.balls = refitted_boxes(model.bvh, balls);
    reorder(model);
    return model;
}

}  // namespace slim
