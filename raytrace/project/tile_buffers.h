#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/project/tile_bins.h"
#include "slim/base/simd.h"

#include <cstddef>
#include <cstdint>
#include <limits>

namespace slim {

inline constexpr std::size_t kTilePixels = static_cast<std::size_t>(kTileSize) * kTileSize;
static_assert(kTileSize % kLanes == 0);

/// One number a pixel of a tile. Lanes begin at any pixel: a surfel's own columns, not the tile's.
struct alignas(64) TilePlane {
    float v[kTilePixels];

    [[gnu::always_inline]] FloatV load(std::size_t i) const { return FloatV(v + i, stdx::element_aligned); }
    [[gnu::always_inline]] void store(std::size_t i, const FloatV& x) {
        x.copy_to(v + i, stdx::element_aligned);
    }
    [[gnu::always_inline]] void add(std::size_t i, const FloatV& x) { store(i, load(i) + x); }
};

/// Work in lanes, whether or not their pixel lies in the surfel's outline.
struct TileCounts {
    std::uint64_t root_tests = 0, distance_tests = 0, covered = 0, unblended = 0;
};

/// The sums that the wanted channels need.
struct TileSums {
    bool hessian, third, depth, count, node;
    explicit TileSums(Channels wanted)
        : hessian((wanted & kHessianChannels) != 0), third((wanted & kThirdOrderChannel) != 0),
          depth((wanted & (kDepthChannel | kPositionChannel)) != 0), count((wanted & kCountChannel) != 0),
          node((wanted & (kSurfelIdChannel | kFitErrorChannel | kLevelChannel)) != 0) {}
};

/// Rows of a tile whose depths are bounded together, column by column.
inline constexpr int kStripRows = 4;
inline constexpr int kStrips = kTileSize / kStripRows;

/// Everything of one tile while it is drawn; lives on the stack of its thread. Depths are camera z minus
/// z_ref, so that floats resolve a small surfel on a far model.
struct TileBuffers {
    int x0 = 0, y0 = 0;  ///< first pixel of the tile, whole picture
    ScreenRect clip;     ///< the tile's pixels inside the window
    double z_ref = 0;
    float near_z = 0;
    TilePlane z;                         ///< q^: +inf before a hit, -inf outside the window
    TilePlane gx, gy, gz;                ///< gradient of the surfel that set it
    TilePlane weight;                    ///< sum G
    TilePlane sum_x, sum_y, sum_z;       ///< sum G grad f
    /// Bounds of q^ over the rows of a strip. While q^ is found `strip_far` has all pixels, afterwards both
    /// have those with a hit.
    alignas(64) float strip_near[kStrips * kTileSize], strip_far[kStrips * kTileSize];
    TilePlane hessian[6];                ///< sum G Hess f, only if curvature or what needs it is wanted
    TilePlane third[10];                 ///< sum G D3 f, only if third derivatives are wanted
    TilePlane offset;                    ///< sum G (z_i - z), only if depths are
    TilePlane winner, count;             ///< position in the tile's list; number of supporters; only if wanted
    TilePlane dx, dy, dz, inv_dz;        ///< unit ray directions, camera axes; only with sharp surfels or positions
    TileCounts counts;

    /// Depths and sums of a tile before stage 1.
    void start(const PixelView& view, const PixelWindow& window, int first_x, int first_y,
               double reference_depth, const TileSums& sums);
    void fill_directions(const PixelView& view);

    PixelRays<FloatV> rays(int tile_y, int group) const;
    /// After lanes of a strip have changed.
    void update_strip(int strip, int first_x);
    /// Fills strip_near and strip_far from q^. Returns whether the tile has a hit.
    bool bound_hits();
};

inline std::size_t group_index(int tile_y, int group) {
    return static_cast<std::size_t>(tile_y * kTileSize + group * kLanes);
}

[[gnu::always_inline]] inline FloatV::mask_type has_hit(const FloatV& z) {
    return stdx::abs(z) < std::numeric_limits<float>::infinity();
}

inline PixelRays<FloatV> TileBuffers::rays(int tile_y, int group) const {
    const std::size_t i = group_index(tile_y, group);
    const FloatV lane([](auto k) { return static_cast<float>(k); });
    return {lane + static_cast<float>(x0 + group * kLanes), FloatV(static_cast<float>(y0 + tile_y)),
            dx.load(i), dy.load(i), dz.load(i), inv_dz.load(i)};
}

inline void TileBuffers::update_strip(int strip, int first_x) {
    FloatV far = z.load(static_cast<std::size_t>(strip * kStripRows * kTileSize + first_x));
    for (int row = 1; row < kStripRows; ++row)
        far = stdx::max(far, z.load(static_cast<std::size_t>((strip * kStripRows + row) * kTileSize + first_x)));
    far.copy_to(strip_far + strip * kTileSize + first_x, stdx::element_aligned);
}

}  // namespace slim
