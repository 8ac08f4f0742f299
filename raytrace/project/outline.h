#pragma once

#include "raytrace/project/patch_bounds.h"
#include "raytrace/project/pixel_records.h"
#include "raytrace/project/screen_rect.h"

#include <array>
#include <cstddef>

namespace slim {

/// An ellipse of the screen that holds a patch, in the (s, t) of its PixelRecord (project/notes/0002):
/// s^2 + 2 (b0 + b1 t) s + c0 + 2 c1 t + c2 t^2 < 0 inside.
struct alignas(32) Outline {
    float b0, b1, c0, c1, c2;
    float left_t, right_t;  ///< t where it reaches farthest to either side
    float unused;
};

/// The outlines of some patches and the pixels of the window whose centres they may hold.
class OutlinedRects {
public:
    /// Of the least ellipsoids of revolution about the patches, as seen. For centres farther off than 4 radii.
    OutlinedRects(const PixelWindow& window, const RayForm& form, const SurfelLanes& surfels,
                  const PatchBounds& patches);
    /// Lane k to *outlines[k] and *rects[k].
    void put(const std::array<Outline*, kSurfelLanes>& outlines, const std::array<ScreenRect*, kSurfelLanes>& rects) const;

private:
    std::array<FloatsOfDouble, 7> numbers_;  ///< as in Outline
    std::array<LanesOfDouble<int>, 4> sides_;  ///< as in ScreenRect
};

}  // namespace slim
