#include "raytrace/project/forward_renderer.h"

#include "raytrace/project/lod_cut.h"
#include "raytrace/project/tile_resolve.h"
#include "raytrace/project/tile_stages.h"
#include "slim/base/parallel.h"

#include <chrono>

namespace slim {
namespace {

class Clock {
public:
    /// Milliseconds since the last lap.
    double lap_ms() {
        const auto now = std::chrono::steady_clock::now();
        const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
        last_ = now;
        return ms;
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// One picture's worth of what all tiles read.
struct Scene {
    const SurfelTree& tree;
    PixelView view;
    PixelWindow window;  ///< as wanted
    PixelWindow grid;    ///< in whole tiles
    const DrawList& list;
    const TileBins& bins;
};

template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird = false>
void draw_tile(const Scene& scene, std::size_t tile, TileBuffers& t, GBuffer& out) {
    const auto entries = scene.bins.of(tile);
    const DrawRecord& nearest = scene.list.records[entries.front()];
    const int column = static_cast<int>(tile) % scene.bins.columns;
    const int row = static_cast<int>(tile) / scene.bins.columns;
    t.start(scene.view, scene.window, scene.grid.x + column * kTileSize,
            scene.grid.y + row * kTileSize,
            nearest.z_center - kHitTrim * static_cast<double>(nearest.radius), kWantHessian,
            kWantThird);
    run_stage_1<Degree, kSharpModel>(scene.list, entries, t);
    run_stage_2<Degree, kWantHessian, kSharpModel, kWantThird>(scene.list, entries, t);
    resolve_tile(scene.view, scene.window, scene.tree, scene.list, entries, t, out);
}

using DrawTile = void (*)(const Scene&, std::size_t, TileBuffers&, GBuffer&);

template <int Degree>
DrawTile choose_of(bool want_hessian, bool sharp) {
    if (want_hessian) return sharp ? draw_tile<Degree, true, true> : draw_tile<Degree, true, false>;
    return sharp ? draw_tile<Degree, false, true> : draw_tile<Degree, false, false>;
}

/// Third derivatives are those of cubic surfels; of others they are zero, and not summed.
DrawTile choose(int degree, Channels wanted, bool sharp) {
    const bool want_hessian = (wanted & kHessianChannels) != 0;
    if (degree >= 3 && (wanted & kThirdOrderChannel) != 0)
        return sharp ? draw_tile<3, true, true, true> : draw_tile<3, true, false, true>;
    if (degree <= 1) return choose_of<1>(want_hessian, sharp);
    return degree == 2 ? choose_of<2>(want_hessian, sharp) : choose_of<3>(want_hessian, sharp);
}

TileCounts draw_tiles(const Scene& scene, DrawTile draw, GBuffer& out) {
    std::vector<TileCounts> counts(scene.bins.n_tiles());
    parallel_blocks(scene.bins.n_tiles(), 1, [&](std::size_t tile, std::size_t) {
        if (scene.bins.of(tile).empty()) return;
        TileBuffers buffers;
        draw(scene, tile, buffers, out);
        counts[tile] = buffers.counts;
    });
    TileCounts sum;
    for (const TileCounts& c : counts) {
        sum.root_tests += c.root_tests;
        sum.distance_tests += c.distance_tests;
        sum.covered += c.covered;
        sum.unblended += c.unblended;
    }
    return sum;
}

}  // namespace

RenderStats render_forward(const SurfelTree& tree, const RenderRequest& request, GBuffer& out) {
    Clock clock;
    RenderStats stats;
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    const PixelWindow window = request.resolved_window();
    const PixelWindow grid = whole_tiles(window);
    out.reset(window.width, window.height, request.wanted);
    CutCounts met;
    const auto cut = lod_cut(tree, view, grid, {request.lod_px, request.loose}, met);
    stats.nodes_visited = met.nodes_visited;
    stats.loose_hidden = met.loose_hidden;
    stats.cut_ms = clock.lap_ms();
    const DrawList list = draw_list(view, grid, tree, cut);
    stats.surfels_drawn = list.records.size();
    stats.decode_ms = clock.lap_ms();
    const TileBins bins = tile_bins(grid, list.full);
    stats.tile_entries = bins.entries.size();
    stats.bin_ms = clock.lap_ms();
    const TileCounts counts =
        draw_tiles({tree, view, window, grid, list, bins},
                   choose(tree.header().degree, request.wanted, !tree.sharp().empty()),
                   out);
    stats.draw_ms = clock.lap_ms();
    stats.root_tests = counts.root_tests;
    stats.distance_tests = counts.distance_tests;
    stats.covered_pixels = counts.covered;
    stats.unblended_pixels = counts.unblended;
    stats.total_ms = stats.cut_ms + stats.decode_ms + stats.bin_ms + stats.draw_ms;
    return stats;
}

}  // namespace slim
