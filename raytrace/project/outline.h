#pragma once

#include "raytrace/project/patch_bounds.h"
#include "raytrace/project/pixel_records.h"
#include "raytrace/project/screen_rect.h"

#include <array>
#include <cstddef>

namespace slim {

/// An ellipse of the screen that holds a patch, in the (s, t) of its PixelRecord
/// (project/notes/0002): s^2 + 2 (b0 + b1 t) s + c0 + 2 c1 t + c2 t^2 < 0 inside.
struct Outline {
    float b0, b1, c0, c1, c2;
    float left_t, right_t;  ///< t where it reaches farthest to either side
};

/// What a tile asks of a surfel first, in one line of the cache.
struct alignas(64) Footprint {
    Outline outline;
    float pixel_x, pixel_y, base_x, base_y, step;  ///< as in PixelRecord
    ScreenRect rect;  ///< the pixels of the window whose centres the outline may hold
};

/// The footprints of some patches.
class Footprints {
public:
    /// Of the least ellipsoids of revolution about the patches,
    /// as seen. For centres farther off than 4 radii.
    Footprints(const PixelWindow& window, const RayForm& form, const PixelGrid& grid,
               const SurfelLanes& surfels, const PatchBounds& patches);
    /// Lane k to *out[k].
    void put(const std::array<Footprint*, kSurfelLanes>& out) const;

private:
    std::array<FloatsOfDouble, 12> numbers_;   ///< as in Footprint
    std::array<LanesOfDouble<int>, 4> sides_;  ///< as in ScreenRect
};

}  // namespace slim
