#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/pixel_record.h"
#include "raytrace/project/marked_tiles.h"
#include "raytrace/project/outline.h"
#include "raytrace/project/screen_rect.h"
#include "raytrace/project/sharp_record.h"
#include "raytrace/renderer.h"
#include "slim/blend/leaf_hessians.h"
#include "slim/model/rim.h"
#include "slim/model/surfel_tree.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace slim {

inline constexpr std::uint32_t kFast = 0xffffffffu;

/// One of something for each entry of a draw list, not set beforehand.
template <class T>
class Entries {
public:
    explicit Entries(std::size_t n) : data_(std::allocator<T>().allocate(n), {n}) {}
    T& operator[](std::size_t i) { return data_.get()[i]; }
    const T& operator[](std::size_t i) const { return data_.get()[i]; }
    const T* data() const { return data_.get(); }
    std::span<const T> span() const { return {data_.get(), data_.get_deleter().n}; }

private:
    static_assert(std::is_trivially_copyable_v<T>);
    struct Free {
        std::size_t n;
        void operator()(T* p) const { std::allocator<T>().deallocate(p, n); }
    };
    std::unique_ptr<T, Free> data_;
};

/// What is known of a surfel of the cut besides its polynomials.
struct alignas(64) DrawItem {
    double z_center;
    double near_hit;               ///< no first hit has a smaller camera z
    double near_blend, far_blend;  ///< where a q^ that it takes part in lies
    float radius, kappa;           ///< as in PixelRecord
    std::uint32_t node;
    std::uint32_t general;         ///< entry in DrawList::general, or kFast
    PackedRims rims;
};

/// The cut, ready to draw, entry by entry.
template <int Degree>
struct DrawList {
    DrawList(std::size_t n, bool with_hessians)
        : items(n), rects(n), whole(n), core(n), records(n), hessians(with_hessians ? n : 0) {}

    Entries<DrawItem> items;
    Entries<ScreenRect> rects;             ///< those of `whole`
    Entries<Footprint> whole, core;  ///< of the surface in the support ball, and
                                     ///< in the ball shrunken by kHitTrim
    Entries<PixelRecord<Degree>> records;  ///< of what is on the screen and not general
    Entries<HessianRecord> hessians;       ///< of the same; none if not wanted
    /// Sharp surfels, and those near the eye or far off the axis.
    std::vector<SharpRecord> general;
    std::vector<std::uint32_t> order;  ///< entries on the screen, by near_hit,
                                       ///< ties in the cut's order
};

/// hessians  of the nodes of the cut, if second derivatives are to be summed; must outlive the
///           list
/// marked    if given: of the window only these tiles are drawn, and what touches none is off the
///           screen
template <int Degree>
DrawList<Degree> draw_list(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                           std::span<const std::uint32_t> cut,
                           const LeafHessians* hessians = nullptr,
                           const MarkedTiles* marked = nullptr);

}  // namespace slim
