#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/project/tile_bins.h"
#include "slim/base/simd.h"

#include <cstddef>
#include <cstdint>

namespace slim {

inline constexpr std::size_t kTilePixels = static_cast<std::size_t>(kTileSize) * kTileSize;
inline constexpr int kGroupsPerRow = kTileSize / kLanes;
inline constexpr std::size_t kGroups = kTilePixels / kLanes;
static_assert(kTileSize % kLanes == 0);

struct alignas(64) TilePlane {
    float v[kTilePixels];

    FloatV load(std::size_t i) const { return FloatV(v + i, stdx::vector_aligned); }
    void store(std::size_t i, const FloatV& x) { x.copy_to(v + i, stdx::vector_aligned); }
    void add(std::size_t i, const FloatV& x) { store(i, load(i) + x); }
};

struct TileCounts {
    std::uint64_t root_tests = 0, distance_tests = 0, covered = 0, unblended = 0;
};

/// Everything of one tile while it is drawn; lives on the stack of its thread. Depths are camera z minus
/// z_ref, so that floats resolve a small surfel on a far model.
struct TileBuffers {
    int x0 = 0, y0 = 0;  ///< first pixel of the tile, whole picture
    ScreenRect clip;     ///< the tile's pixels inside the window
    double z_ref = 0;
    float near_z = 0;
    TilePlane dx, dy, dz, inv_dz;        ///< unit ray directions, camera axes
    TilePlane z;                         ///< q^: +inf before a hit, -inf outside the window
    TilePlane winner;                    ///< position in the tile's list, -1 without a hit
    TilePlane gx, gy, gz;                ///< gradient of the winner
    TilePlane weight, offset, count;     ///< sum G, sum G (z_i - z), number of supporters
    TilePlane sum_x, sum_y, sum_z;       ///< sum G grad f
    TilePlane hessian[6];                ///< sum G Hess f, only if curvature is wanted
    TilePlane third[10];                 ///< sum G D3 f, only if third derivatives are wanted
    float group_near[kGroups], group_far[kGroups];  ///< range of q^ over the lanes of a group
    TileCounts counts;

    /// Rays, depths and sums of a tile before stage 1.
    void start(const PixelView& view, const PixelWindow& window, int first_x, int first_y,
               double reference_depth, bool want_hessian, bool want_third = false);

    PixelRays<FloatV> rays(int tile_y, int group) const;
    /// Largest depth of the tile's pixels, +inf while one is uncovered.
    float farthest() const;
    /// Fills group_near and group_far from q^. Returns whether the tile has a hit.
    bool update_group_ranges();
};

inline std::size_t group_index(int tile_y, int group) {
    return static_cast<std::size_t>(tile_y * kTileSize + group * kLanes);
}

inline PixelRays<FloatV> TileBuffers::rays(int tile_y, int group) const {
    const std::size_t i = group_index(tile_y, group);
    const FloatV lane([](auto k) { return static_cast<float>(k); });
    return {lane + static_cast<float>(x0 + group * kLanes), FloatV(static_cast<float>(y0 + tile_y)),
            dx.load(i), dy.load(i), dz.load(i), inv_dz.load(i)};
}

}  // namespace slim
