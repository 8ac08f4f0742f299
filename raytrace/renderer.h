#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"

#include <cstdint>
#include <functional>
#include <span>

namespace slim {

class LeafHessians;

/// Part of a picture: `width` x `height` pixels from (x, y) on. Width 0: the whole picture.
struct PixelWindow {
    int x = 0, y = 0, width = 0, height = 0;
};

/// What a renderer is given, besides the model.
struct RenderRequest {
    Camera camera;
    int width = 1600, height = 1200;  ///< of the whole picture
    Channels wanted = kDepthChannel | kNormalChannel;
    double lod_px = 4;      ///< descend while a ball's projected
                            ///< diameter exceeds it; 0: leaves only
    PixelWindow window{};   ///< the part to render; the G-buffer has its size
    bool loose = false;     ///< draw loose surfels as well (kLoose)
    /// First hits in doubt give way to what lies behind them where most surfels say that the ray
    /// passes over (is_in_doubt in slim/blend): silhouettes without flaps and crumbs.
    bool clean_outlines = false;
    /// What is known of the leaves' second derivatives, of the tree that is drawn: kept from
    /// picture to picture, where channels want them. Null: worked out for this one. In the forward
    /// renderer only.
    LeafHessians* hessians = nullptr;
    /// If set: gets the nodes that the cut met, and leaves beside them where `hessians` asks for
    /// these, before their surfels are looked at. In the forward renderer only: the others go
    /// through all leaves.
    std::function<void(std::span<const std::uint32_t>)> on_met = {};

    /// The window, resolved and checked against the picture (ConfigError).
    PixelWindow resolved_window() const;
};

/// What it cost and what came out. Times are wall clock; counts do not depend on threads.
struct RenderStats {
    std::uint64_t nodes_visited = 0;
    std::uint64_t surfels_drawn = 0;    ///< in the cut and on the screen
    std::uint64_t loose_hidden = 0;     ///< loose surfels left out of the cut
    std::uint64_t tile_entries = 0;     ///< (surfel, tile) pairs
    std::uint64_t root_tests = 0;       ///< lanes whose root was asked for, both stages
    std::uint64_t distance_tests = 0;   ///< lanes of the test |q^ - c| < rho
    /// Blocks of kLanes pixels (16 with AVX-512, else 8) in a surfel's outline that are passed over
    /// without a test, in both stages: all that is seen there is nearer, or out of the ball's
    /// reach. Forward renderer only, and smooth surfels.
    std::uint64_t blocks_passed = 0;
    /// (surfel, tile) pairs that are left out at once: the rest of a tile's list once it lies
    /// behind all that is seen there (stage 1), and balls that reach no hit of the tile (stage 2).
    /// Forward renderer only.
    std::uint64_t surfels_cut_off = 0;
    std::uint64_t covered_pixels = 0;
    std::uint64_t unblended_pixels = 0; ///< hit, but without weight in stage 2: they keep q^
    double cut_ms = 0, decode_ms = 0, bin_ms = 0, draw_ms = 0, total_ms = 0;
};

}  // namespace slim
