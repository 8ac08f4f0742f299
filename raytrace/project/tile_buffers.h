#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/project/block_mask.h"
#include "raytrace/project/tile_blocks.h"
#include "raytrace/sample_mask.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace slim {

/// One number a pixel of a tile, block by block; i is a block's first entry.
struct alignas(64) TilePlane {
    float v[kTilePixels];

    [[gnu::always_inline]] FloatV load(std::size_t i) const {
        return FloatV(v + i, stdx::vector_aligned);
    }
    [[gnu::always_inline]] void store(std::size_t i, const FloatV& x) {
        x.copy_to(v + i, stdx::vector_aligned);
    }
    [[gnu::always_inline]] void add(std::size_t i, const FloatV& x) { store(i, load(i) + x); }
};

/// Work in lanes, whether or not their pixel lies in the surfel's outline.
struct TileCounts {
    std::uint64_t root_tests = 0, distance_tests = 0, covered = 0, unblended = 0;
    std::uint64_t blocks_passed = 0, surfels_cut_off = 0;  ///< of RenderStats
};

/// The sums that the wanted channels need.
struct TileSums {
    bool hessian, third, depth, count, node;
    explicit TileSums(Channels wanted)
        : hessian((wanted & kHessianChannels) != 0),
          third((wanted & kThirdOrderChannel) != 0),
          depth((wanted & (kDepthChannel | kPositionChannel)) != 0),
          count((wanted & kCountChannel) != 0),
          node((wanted & (kSurfelIdChannel | kFitErrorChannel | kLevelChannel)) != 0) {}
};

/// The depths of a tile: its own coordinate is affine in that of every surfel (PixelRecord), in
/// perspective views zeta = (z - z_ref) z_ref / z, in orthographic ones z - z_ref. Floats resolve a
/// small surfel on a far model: their error at z is 2^-24 |z / z_ref - 1| z, so that z_ref is to be
/// the far end of what is seen.
struct TileDepths {
    double z_ref = 0;
    double per_ref = 0;  ///< 1 / z_ref; 0 in orthographic views
    double near = 0;     ///< z - z_ref of the near plane

    /// zeta of z - z_ref, and back.
    template <class T>
    T zeta(const T& z) const { return z / (T(1) + z * constant<T>(per_ref)); }
    template <class T>
    T relative(const T& zeta) const { return zeta / (T(1) - zeta * constant<T>(per_ref)); }

    /// zeta of a camera z, or of the near plane if that is farther.
    float at(double z) const { return static_cast<float>(zeta(std::max(z - z_ref, near))); }
    /// The camera z of a zeta.
    double z_of(float at_zeta) const { return z_ref + relative(static_cast<double>(at_zeta)); }
};

/// Everything of one tile while it is drawn; lives on the stack of its thread.
struct TileBuffers {
    int x0 = 0, y0 = 0;  ///< first pixel of the tile, whole picture
    PixelPlaces places;
    ScreenRect clip;     ///< the tile's pixels inside the window
    TileDepths depths;
    float near_z = 0;                    ///< the near plane's z - z_ref
    float near = 0, far = 0;             ///< zeta of q^ within the tile, after bound_hits
    alignas(64) float block_near[kTileBlocks], block_far[kTileBlocks];  ///< and within each block
    TilePlane z;                         ///< zeta of q^: +inf before a hit, -inf outside the window
    TilePlane gx, gy, gz;                ///< gradient of the surfel that set it
    TilePlane weight;                    ///< sum G
    TilePlane sum_x, sum_y, sum_z;       ///< sum G grad f
    TilePlane hessian[6];                ///< sum G Hess f, only if curvature or
                                         ///< what needs it is wanted
    TilePlane third[10];                 ///< sum G D3 f, only if third derivatives are wanted
    TilePlane offset;                    ///< sum G (z_i - z), only if depths are
    TilePlane winner, count;             ///< position in the tile's list; number of
                                         ///< supporters; only if wanted
    TilePlane dx, dy, dz, inv_dz;        ///< unit ray directions, camera axes; only with sharp
                                         ///< surfels or positions
    TilePlane passing, last_z;           ///< of picked pixels (PickedPixels) only
    TileCounts counts;

    /// Depths and sums of a tile before stage 1.
    void start(const PixelView& view, const PixelWindow& window, int first_x, int first_y,
               double reference_depth, const TileSums& sums);
    /// All but some samples are as outside the window. After start.
    void leave_out_others(const SampleMask& only);
    void fill_directions(const PixelView& view);

    /// The part of a rectangle of the picture on the tile and in the window,
    /// in the tile's own pixels.
    ScreenRect on_tile(const ScreenRect& r) const {
        return {std::max(r.x0, clip.x0) - x0, std::max(r.y0, clip.y0) - y0,
                std::min(r.x1, clip.x1) - x0, std::min(r.y1, clip.y1) - y0};
    }
    PixelRays<FloatV> rays(int block) const;
    /// Fills block_far with the greatest zeta of all pixels, +inf as long as one has no hit;
    /// returns that of the tile.
    float bound_pixels();
    /// Fills near and far from q^, of the tile and of its blocks. Returns whether the tile has a
    /// hit.
    bool bound_hits();
    /// Blocks in which something is farther than this, and those in which something lies between.
    BlockMask beyond(float zeta) const;
    BlockMask within(float least, float most) const;
};

[[gnu::always_inline]] inline FloatV::mask_type has_hit(const FloatV& z) {
    return stdx::abs(z) < std::numeric_limits<float>::infinity();
}

[[gnu::always_inline]] inline BlockMask TileBuffers::beyond(float zeta) const {
    BlockMask blocks;
    for (std::size_t k = 0; k < kTileBlocks; k += kLanes)
        blocks.add(k, lane_bits(FloatV(block_far + k, stdx::vector_aligned) > zeta));
    return blocks;
}

[[gnu::always_inline]] inline BlockMask TileBuffers::within(float least, float most) const {
    BlockMask blocks;
    for (std::size_t k = 0; k < kTileBlocks; k += kLanes) {
        const FloatV block_least(block_near + k, stdx::vector_aligned),
            block_most(block_far + k, stdx::vector_aligned);
        blocks.add(k, lane_bits(block_most >= least && block_least <= most));
    }
    return blocks;
}

inline PixelRays<FloatV> TileBuffers::rays(int block) const {
    const auto i = static_cast<std::size_t>(block * kLanes);
    return {places.column(block) + static_cast<float>(x0),
            places.row(block) + static_cast<float>(y0),
            dx.load(i), dy.load(i), dz.load(i), inv_dz.load(i)};
}

}  // namespace slim
