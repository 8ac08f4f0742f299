#pragma once

#include "raytrace/project/patch_bounds.h"
#include "raytrace/project/pixel_records.h"
#include "raytrace/project/screen_rect.h"

#include <cstddef>

namespace slim {

/// An ellipse of the screen that holds a patch, in the (s, t) of its PixelRecord (project/notes/0002):
/// s^2 + 2 (b0 + b1 t) s + c0 + 2 c1 t + c2 t^2 < 0 inside.
struct Outline {
    float b0, b1, c0, c1, c2;
    float left_t, right_t;  ///< t where it reaches farthest to either side
};

/// The outlines of some patches and the pixels of the window whose centres they may hold.
class OutlinedRects {
public:
    /// Of the least ellipsoids of revolution about the patches, as seen. For centres farther off than 4 radii.
    OutlinedRects(const PixelWindow& window, const RayForm& form, const SurfelLanes& surfels,
                  const PatchBounds& patches);
    Outline outline(std::size_t lane) const {
        const auto of = [&](std::size_t k) { return numbers_[k][lane]; };
        return {of(0), of(1), of(2), of(3), of(4), of(5), of(6)};
    }
    ScreenRect rect(std::size_t lane) const {
        const auto of = [&](std::size_t k) { return sides_[k][lane]; };
        return {of(0), of(1), of(2), of(3)};
    }

private:
    alignas(64) float numbers_[7][kSurfelLanes];  ///< as in Outline
    alignas(64) int sides_[4][kSurfelLanes];      ///< as in ScreenRect
};

}  // namespace slim
