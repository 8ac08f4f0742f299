#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/intersect/sharp_kernel.h"
#include "raytrace/renderer.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Pixels [x0, x1) x [y0, y1) of the whole picture.
struct ScreenRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// Pixels of the window whose centre's ray may meet the ball in front of the near plane: exact bounds
/// per axis for a ball in front of the eye's plane (NUMERICS 7.2), the whole window otherwise.
ScreenRect screen_rect(const PixelView& view, const PixelWindow& window, const Vec3d& center,
                       double radius);

/// One surfel in the form of the kernels; doubles inside, floats out.
DrawRecord draw_record(const PixelView& view, const SurfelTree& tree, std::uint32_t node);

/// The same of a sharp surfel, sheet by sheet.
SharpRecord sharp_record(const PixelView& view, const SurfelTree& tree, std::uint32_t node);

inline constexpr std::uint32_t kSmooth = 0xffffffffu;

/// The cut, ready to draw, nearest first (ties in node order); what misses the window is left out.
struct DrawList {
    std::vector<DrawRecord> records;
    std::vector<ScreenRect> full;     ///< of the support ball
    std::vector<ScreenRect> trimmed;  ///< of the ball shrunken by kHitTrim
    std::vector<PackedRims> rims;
    std::vector<SharpRecord> sharp;       ///< the sharp ones, in the same order
    /// Of each record its entry in `sharp` or kSmooth; empty in smooth models.
    std::vector<std::uint32_t> sharp_of;

    const SharpRecord* sharp_at(std::uint32_t record) const {
        return sharp_of[record] == kSmooth ? nullptr : &sharp[sharp_of[record]];
    }
};

DrawList draw_list(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                   std::span<const std::uint32_t> cut);

}  // namespace slim
