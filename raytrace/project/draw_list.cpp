#include "raytrace/project/draw_list.h"

#include "raytrace/project/depth_order.h"
#include "raytrace/project/pixel_records.h"
#include "slim/base/parallel.h"
#include "slim/model/stand_in.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

namespace slim {
namespace {

/// A float not above x.
float float_below(double x) {
    const auto nearest = static_cast<float>(x);
    return nearest - std::abs(nearest) * std::numeric_limits<float>::epsilon();
}

/// Near the eye or beyond 64 degrees off the axis, where what a PixelRecord adds up is no longer of
/// the order of 1.
bool is_extreme(const PixelView& view, const Vec3d& c, double radius) {
    constexpr double kSqSlope = 4;
    if (view.orthographic) return false;
    return c.z <= 4 * radius || c.x * c.x + c.y * c.y > kSqSlope * c.z * c.z;
}

/// A sharp surfel reaches anywhere in its ball.
void bound_ball(const PixelView& view, const PixelWindow& window, const Vec3d& c, double radius,
                DrawItem& item, Footprint& whole, Footprint& core) {
    whole = core = {};
    whole.rect = screen_rect(view, window, c, radius);
    core.rect = screen_rect(view, window, c, kHitTrim * radius);
    item.near_hit = c.z - kHitTrim * radius;
    item.near_blend = c.z - radius, item.far_blend = c.z + radius;
}

void leave_out_unmarked(const MarkedTiles* marked, ScreenRect& rect) {
    if (marked && !rect.empty() && !marked->any(rect)) rect = {};
}

/// Whether a ball is seen on tiles that are drawn, before more is known of its surfel.
bool may_be_seen(const PixelView& view, const PixelWindow& window, const Vec3d& c, double radius,
                 const MarkedTiles* marked) {
    if (!marked) return true;
    const ScreenRect rect = screen_rect(view, window, c, radius);
    return !rect.empty() && marked->any(rect);
}

/// Surfels of the cut that have records, worked out side by side.
template <int Degree>
class RecordBatch {
public:
    RecordBatch(const PixelView& view, const PixelWindow& window, const LeafHessians* hessians,
                const MarkedTiles* marked, DrawList<Degree>& list)
        : view_(view), window_(window), hessians_(hessians), marked_(marked), list_(list) {}

    /// Entry i of the list, which is a node of the tree;
    /// `c` is the surfel's centre in camera coordinates.
    void add(const Vec3d& c, const SurfelTree& tree, std::uint32_t node, std::size_t i) {
        entry_[batch_.size()] = i;
        const float* record = tree.record(node);
        const Octahedral normal{record[4], record[5]};
        const auto n = static_cast<std::size_t>(floats_per_surfel(tree.record_degree(node)) - 6);
        if (drawn_scale(tree.node(node)) != 1) {
            const Surfel s = drawn_surfel(tree, node);
            batch_.add(c, s.support_radius, normal,
                       std::span<const double, kStored>(s.polynomial.a.data(), kStored));
        } else if (n == kStored) {
            batch_.add(c, double{record[3]}, normal,
                       std::span<const float, kStored>(record + 6, kStored));
        } else {
            std::array<float, kStored> a{};
            std::copy_n(record + 6, std::min(n, kStored), a.begin());
            batch_.add(c, double{record[3]}, normal, std::span<const float, kStored>(a));
        }
        if (batch_.full()) work_out();
    }
    /// Those added since the last full batch.
    void work_out() {
        if (batch_.size() == 0) return;
        const SurfelLanes s = batch_.lanes(view_);
        const RayForm form = ray_form(view_, s);
        const PatchBounds whole = patch_bounds(s, 1), core = patch_bounds(s, kHitTrim);
        const PixelGrid grid(form);
        std::array<Footprint*, kSurfelLanes> to_whole, to_core;
        for (std::size_t k = 0; k < kSurfelLanes; ++k) {  // further lanes repeat the last one
            const std::size_t i = entry_[std::min(k, batch_.size() - 1)];
            to_whole[k] = &list_.whole[i], to_core[k] = &list_.core[i];
        }
        Footprints(window_, form, grid, s, whole).put(to_whole);
        Footprints(window_, form, grid, s, core).put(to_core);
        put_depths(s, form, whole, core);
        std::array<PixelRecord<Degree>*, kSurfelLanes> records{};
        bool any = false;
        for (std::size_t k = 0; k < batch_.size(); ++k) {
            leave_out_unmarked(marked_, to_whole[k]->rect);
            if (!to_whole[k]->rect.empty()) records[k] = &list_.records[entry_[k]], any = true;
        }
        if (any) fill_pixel_records<Degree>(s, form, grid, records);
        if (any && hessians_) put_hessians(s, records);
        batch_.clear();
    }

private:
    /// Coefficients that a record of the model's own degree has.
    static constexpr auto kStored = static_cast<std::size_t>(floats_per_surfel(Degree) - 6);

    void put_depths(const SurfelLanes& s, const RayForm& form, const PatchBounds& whole,
                    const PatchBounds& core) const {
        const Heading toward(s.e_w);
        // q^ lies in the ball and no farther than kBelongs from the surface.
        const auto blended = [&](bool forth) {
            return stdx::min(s.radius, whole.support(toward, forth) + kBelongs * s.radius);
        };
        const DoubleV& z = s.center.z;
        alignas(64) double near_hit[kSurfelLanes], near_blend[kSurfelLanes],
            far_blend[kSurfelLanes];
        (z - core.support(toward, false)).copy_to(near_hit, stdx::vector_aligned);
        (z - blended(false)).copy_to(near_blend, stdx::vector_aligned);
        (z + blended(true)).copy_to(far_blend, stdx::vector_aligned);
        alignas(64) float radius[kSurfelLanes], kappa[kSurfelLanes];
        floats_of(s.radius).copy_to(radius, stdx::vector_aligned);
        floats_of(form.kappa).copy_to(kappa, stdx::vector_aligned);
        for (std::size_t k = 0; k < batch_.size(); ++k) {
            DrawItem& item = list_.items[entry_[k]];
            item.radius = radius[k], item.kappa = kappa[k];
            item.near_hit = near_hit[k], item.near_blend = near_blend[k],
            item.far_blend = far_blend[k];
        }
    }

    void put_hessians(const SurfelLanes& s,
                      const std::array<PixelRecord<Degree>*, kSurfelLanes>& wanted) const {
        for (std::size_t k = 0; k < batch_.size(); ++k) {
            if (!wanted[k]) continue;
            HessianRecord& r = list_.hessians[entry_[k]];
            for (std::size_t axis = 0; axis < 3; ++axis)
                r.u_axis[axis] = static_cast<float>(s.e_u[axis][k]),
                r.v_axis[axis] = static_cast<float>(s.e_v[axis][k]);
            r.inv_radius = static_cast<float>(1 / s.radius[k]);
            if (const HeightHessian* known = hessians_->of(list_.items[entry_[k]].node)) {
                r.p = *known;
                continue;
            }
            Polynomial<double> p;
            for (std::size_t i = 0; i < p.a.size(); ++i) p.a[i] = s.a[i][k];
            r.p = hessian_of(p);
        }
    }

    const PixelView& view_;
    const PixelWindow& window_;
    const LeafHessians* hessians_;
    const MarkedTiles* marked_;
    DrawList<Degree>& list_;
    SurfelBatch batch_;
    std::array<std::size_t, kSurfelLanes> entry_{};
};

template <int Degree>
void fill_entry(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                std::uint32_t node, std::size_t i, const MarkedTiles* marked,
                DrawList<Degree>& list, RecordBatch<Degree>& batch) {
    const Vec3d c = view.camera_from_local(tree.center(node));
    const std::uint8_t flags = tree.node(node).flags;
    const double radius = tree.support_radius(node) * drawn_scale(tree.node(node));
    DrawItem& item = list.items[i];
    item.z_center = item.near_hit = c.z;
    item.radius = static_cast<float>(radius), item.kappa = 0;
    item.node = node, item.general = kFast, item.rims = tree.node(node).rims();
    if ((flags & kSharp) || is_extreme(view, c, radius)) {
        item.general = 0;
        bound_ball(view, window, c, radius, item, list.whole[i], list.core[i]);
        leave_out_unmarked(marked, list.whole[i].rect);
    } else if (c.z + radius >= view.near_plane && may_be_seen(view, window, c, radius, marked)) {
        batch.add(c, tree, node, i);
    } else {
        list.whole[i].rect = {};
    }
}

/// What the general kernels draw, in order.
template <int Degree>
void add_general(const PixelView& view, const SurfelTree& tree, const LeafHessians* hessians,
                 DrawList<Degree>& list) {
    for (const std::uint32_t i : list.order) {
        DrawItem& item = list.items[i];
        if (item.general == kFast) continue;
        item.general = static_cast<std::uint32_t>(list.general.size());
        list.general.push_back(sharp_record(view, drawn_surfel(tree, item.node), item.node));
        if (hessians) list.general.back().hessian = hessians->of(item.node);
    }
}

}  // namespace

template <int Degree>
DrawList<Degree> draw_list(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                           std::span<const std::uint32_t> cut, const LeafHessians* hessians,
                           const MarkedTiles* marked) {
    DrawList<Degree> list(cut.size(), hessians != nullptr);
    std::vector<std::uint32_t> keys(cut.size());
    std::atomic<bool> any_general = false;
    const double z_root = tree.n_nodes() > 0 ? view.camera_from_local(tree.center(0)).z : 0;
    constexpr std::size_t kGrain = 512;
    parallel_blocks(cut.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        RecordBatch<Degree> batch(view, window, hessians, marked, list);
        for (std::size_t i = begin; i < end; ++i)
            fill_entry(view, window, tree, cut[i], i, marked, list, batch);
        batch.work_out();
        for (std::size_t i = begin; i < end; ++i) {
            list.rects[i] = list.whole[i].rect;
            double& near = list.items[i].near_hit;
            const float key = float_below(near - z_root);
            keys[i] = ordered_bits(key);
            // the order is that of near_hit to the last bit
            near = z_root + static_cast<double>(key);
            if (list.items[i].general != kFast) any_general = true;
        }
    });
    list.order = sorted_order(keys, list.rects.span());
    if (any_general) add_general(view, tree, hessians, list);
    return list;
}

template DrawList<1> draw_list<1>(const PixelView&, const PixelWindow&, const SurfelTree&,
                                  std::span<const std::uint32_t>, const LeafHessians*,
                                  const MarkedTiles*);
template DrawList<2> draw_list<2>(const PixelView&, const PixelWindow&, const SurfelTree&,
                                  std::span<const std::uint32_t>, const LeafHessians*,
                                  const MarkedTiles*);
template DrawList<3> draw_list<3>(const PixelView&, const PixelWindow&, const SurfelTree&,
                                  std::span<const std::uint32_t>, const LeafHessians*,
                                  const MarkedTiles*);

}  // namespace slim
