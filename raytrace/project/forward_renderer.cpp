#include "raytrace/project/forward_renderer.h"

#include "raytrace/project/lod_cut.h"
#include "raytrace/project/tile_doubts.h"
#include "raytrace/project/tile_resolve.h"
#include "raytrace/project/tile_stage_1.h"
#include "raytrace/project/tile_stage_2.h"
#include "slim/base/parallel.h"

#include <chrono>
#include <cstdint>
#include <vector>

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
template <int Degree>
struct Scene {
    const SurfelTree& tree;
    PixelView view;
    PixelWindow window;  ///< as wanted
    PixelWindow grid;    ///< in whole tiles
    const DrawList<Degree>& list;
    const TileBins& bins;
    TileSums sums;
    bool with_directions;  ///< of the rays: the general kernels and positions need them
    const SampleMask* only = nullptr;  ///< what of the window is drawn, if not all

    int first_x(std::size_t tile) const {
        return grid.x + static_cast<int>(tile) % bins.columns * kTileSize;
    }
    int first_y(std::size_t tile) const {
        return grid.y + static_cast<int>(tile) / bins.columns * kTileSize;
    }
    /// Whether a tile shows nothing that is wanted.
    bool is_empty(std::size_t tile) const {
        return bins.of(tile).empty() ||
               (only && !only->any_sample({first_x(tile), first_y(tile), kTileSize, kTileSize}));
    }
};

template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird = false>
void draw_tile(const Scene<Degree>& scene, std::size_t tile, TileBuffers& t, GBuffer& out) {
    const auto entries = scene.bins.of(tile);
    t.start(scene.view, scene.window, scene.first_x(tile), scene.first_y(tile),
            scene.list.items[entries.back()].far_blend, scene.sums);
    if (scene.only) t.leave_out_others(*scene.only);
    fetch_tile(scene.window, scene.first_x(tile), scene.first_y(tile), out);
    if (scene.with_directions) t.fill_directions(scene.view);
    run_stage_1<Degree>(scene.list, entries, scene.sums, t);
    run_stage_2<Degree, kWantHessian, kSharpModel, kWantThird>(scene.list, entries, scene.sums, t);
    settle_doubts<Degree, kWantHessian, kSharpModel, kWantThird>(scene.view, scene.list, entries,
                                                                 scene.sums, t);
    resolve_tile(scene.view, scene.window, scene.tree, scene.list.items.span(), entries, scene.sums,
                 t, out);
}

template <int Degree>
using DrawTile = void (*)(const Scene<Degree>&, std::size_t, TileBuffers&, GBuffer&);

/// Third derivatives are those of cubic surfels; of others they are zero, and not summed.
template <int Degree>
DrawTile<Degree> choose(const TileSums& sums, bool sharp) {
    if constexpr (Degree == 3)
        if (sums.third)
            return sharp ? draw_tile<3, true, true, true> : draw_tile<3, true, false, true>;
    if (sums.hessian) return sharp ? draw_tile<Degree, true, true> : draw_tile<Degree, true, false>;
    return sharp ? draw_tile<Degree, false, true> : draw_tile<Degree, false, false>;
}

struct TileRun {
    std::size_t first;
    int n;
    bool is_empty;
};

/// Tiles to draw, one by one, and empty ones as long as they follow each other in a row.
template <int Degree>
std::vector<TileRun> tile_runs(const Scene<Degree>& scene) {
    std::vector<TileRun> runs;
    for (std::size_t tile = 0; tile < scene.bins.n_tiles(); ++tile) {
        const bool begins_row = tile % static_cast<std::size_t>(scene.bins.columns) == 0;
        const bool is_empty = scene.is_empty(tile);
        if (!begins_row && is_empty && runs.back().is_empty) ++runs.back().n;
        else runs.push_back({tile, 1, is_empty});
    }
    return runs;
}

template <int Degree>
TileCounts draw_tiles(const Scene<Degree>& scene, GBuffer& out) {
    const DrawTile<Degree> draw = choose<Degree>(scene.sums, !scene.tree.sharp().empty());
    std::vector<TileCounts> counts(scene.bins.n_tiles());
    const auto runs = tile_runs(scene);
    parallel_blocks(runs.size(), 1, [&](std::size_t run, std::size_t) {
        const auto [tile, n, is_empty] = runs[run];
        if (is_empty)
            return clear_tiles(scene.window, scene.first_x(tile), scene.first_y(tile), n, out);
        TileBuffers buffers;
        draw(scene, tile, buffers, out);
        counts[tile] = buffers.counts;
    });
    TileCounts sum;
    for (const TileCounts& c : counts) {
        sum.root_tests += c.root_tests;
        sum.distance_tests += c.distance_tests;
        sum.blocks_passed += c.blocks_passed;
        sum.surfels_cut_off += c.surfels_cut_off;
        sum.covered += c.covered;
        sum.unblended += c.unblended;
    }
    return sum;
}

void put_counts(const TileCounts& counts, RenderStats& stats) {
    stats.root_tests = counts.root_tests;
    stats.distance_tests = counts.distance_tests;
    stats.blocks_passed = counts.blocks_passed;
    stats.surfels_cut_off = counts.surfels_cut_off;
    stats.covered_pixels = counts.covered;
    stats.unblended_pixels = counts.unblended;
}

/// Draws a cut of a model of this degree.
template <int Degree>
void draw_cut(const SurfelTree& tree, const PixelView& view, const PixelWindow& window,
              std::span<const std::uint32_t> cut, const SampleMask* only, Clock& clock,
              RenderStats& stats, GBuffer& out) {
    const PixelWindow grid = whole_tiles(window);
    const DrawList<Degree> list = draw_list<Degree>(view, grid, tree, cut);
    stats.surfels_drawn = list.order.size();
    stats.decode_ms = clock.lap_ms();
    const TileBins bins = tile_bins(grid, list.rects.span(), list.order);
    stats.tile_entries = bins.entries.size();
    stats.bin_ms = clock.lap_ms();
    const bool with_directions = !list.general.empty() || out.has(kPositionChannel);
    put_counts(
        draw_tiles<Degree>(
            {tree, view, window, grid, list, bins, TileSums(out.channels), with_directions, only},
            out),
        stats);
    stats.draw_ms = clock.lap_ms();
}

}  // namespace

RenderStats render_forward(const SurfelTree& tree, const RenderRequest& request, GBuffer& out,
                           const SampleMask* only) {
    Clock clock;
    RenderStats stats;
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    const PixelWindow window = request.resolved_window();
    out.resize(window.width, window.height, request.wanted);
    CutCounts met;
    std::vector<std::uint32_t> visited;
    if (request.on_met) met.visited = &visited;
    const auto cut = lod_cut(tree, view, whole_tiles(window), {request.lod_px, request.loose}, met);
    stats.nodes_visited = met.nodes_visited;
    stats.loose_hidden = met.loose_hidden;
    if (request.on_met) request.on_met(visited);
    stats.cut_ms = clock.lap_ms();
    const int degree = tree.header().degree;
    const auto draw = degree <= 1 ? draw_cut<1> : degree == 2 ? draw_cut<2> : draw_cut<3>;
    draw(tree, view, window, cut, only, clock, stats, out);
    stats.total_ms = stats.cut_ms + stats.decode_ms + stats.bin_ms + stats.draw_ms;
    return stats;
}

}  // namespace slim
