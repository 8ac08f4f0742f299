#include "raytrace/project/forward_picture.h"

#include "raytrace/project/ball_reach.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/lod_cut.h"
#include "raytrace/project/marked_tiles.h"
#include "raytrace/project/tile_bins.h"
#include "raytrace/project/tile_doubts.h"
#include "raytrace/project/tile_resolve.h"
#include "raytrace/project/tile_stage_1.h"
#include "raytrace/project/tile_stage_2.h"
#include "slim/base/parallel.h"

#include <chrono>
#include <cstdint>
#include <optional>
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

/// A window's worth of what all tiles read.
template <int Degree>
struct Scene {
    const SurfelTree& tree;
    PixelView view;
    PixelWindow window;  ///< as wanted
    PixelWindow grid;    ///< what is binned, in whole tiles
    const DrawList<Degree>& list;
    const TileBins& bins;
    TileSums sums;
    bool with_directions;  ///< of the rays: the general kernels and positions need them
    bool clean_outlines;   ///< as in RenderRequest
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
    /// Tiles of the grid that the window touches: of a row from the first on.
    std::size_t tile_at(int x, int y) const {
        return static_cast<std::size_t>((y - grid.y) / kTileSize) *
                   static_cast<std::size_t>(bins.columns) +
               static_cast<std::size_t>((x - grid.x) / kTileSize);
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
    if (scene.clean_outlines)
        settle_doubts<Degree, kWantHessian, kSharpModel, kWantThird>(scene.view, scene.list,
                                                                     entries, scene.sums, t);
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
    const PixelWindow tiles = whole_tiles(scene.window);
    for (int y = tiles.y; y < tiles.y + tiles.height; y += kTileSize) {
        const std::size_t first = scene.tile_at(tiles.x, y),
                          end = first + static_cast<std::size_t>(tiles.width / kTileSize);
        for (std::size_t tile = first; tile < end; ++tile) {
            const bool is_empty = scene.is_empty(tile);
            if (tile != first && is_empty && runs.back().is_empty) ++runs.back().n;
            else runs.push_back({tile, 1, is_empty});
        }
    }
    return runs;
}

template <int Degree>
TileCounts draw_tiles(const Scene<Degree>& scene, GBuffer& out) {
    const DrawTile<Degree> draw = choose<Degree>(scene.sums, !scene.tree.sharp().empty());
    const auto runs = tile_runs(scene);
    std::vector<TileCounts> counts(runs.size());
    parallel_blocks(runs.size(), 1, [&](std::size_t run, std::size_t) {
        const auto [tile, n, is_empty] = runs[run];
        if (is_empty)
            return clear_tiles(scene.window, scene.first_x(tile), scene.first_y(tile), n, out);
        TileBuffers buffers;
        draw(scene, tile, buffers, out);
        counts[run] = buffers.counts;
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

}  // namespace

/// What drawing a window needs, whatever the degree.
class ForwardPicture::Ready {
public:
    virtual ~Ready() = default;
    virtual TileCounts draw(const PixelWindow& window, GBuffer& out) const = 0;
};

template <int Degree>
class ForwardPicture::ReadyOf : public Ready {
public:
    ReadyOf(const SurfelTree& tree, const PixelView& view, const PixelWindow& grid,
            std::span<const std::uint32_t> cut, const LeafHessians* hessians,
            const SampleMask* only, bool clean_outlines, RenderStats& stats)
        : tree_(tree),
          view_(view),
          grid_(grid),
          only_(only),
          clean_outlines_(clean_outlines),
          list_(list_of(cut, hessians, stats)),
          bins_(bins_of(stats)) {}

    TileCounts draw(const PixelWindow& window, GBuffer& out) const override {
        const bool with_directions = !list_.general.empty() || out.has(kPositionChannel);
        return draw_tiles<Degree>({tree_, view_, window, grid_, list_, bins_,
                                   TileSums(out.channels), with_directions,
                                   clean_outlines_, only_},
                                  out);
    }

private:
    DrawList<Degree> list_of(std::span<const std::uint32_t> cut, const LeafHessians* hessians,
                             RenderStats& stats) const {
        Clock clock;
        std::optional<MarkedTiles> marked;
        if (only_) marked.emplace(*only_, grid_);
        auto list = draw_list<Degree>(view_, grid_, tree_, cut, hessians,
                                      marked ? &*marked : nullptr);
        stats.surfels_drawn = list.order.size();
        stats.decode_ms += clock.lap_ms();
        return list;
    }
    TileBins bins_of(RenderStats& stats) {
        Clock clock;
        // A ball has a say where its surface does not reach.
        if (clean_outlines_)
            for (const std::uint32_t i : list_.order)
                if (list_.items[i].general == kFast)
                    list_.rects[i] =
                        joined(BallDisc(view_, list_.whole[i], list_.items[i].kappa),
                               list_.rects[i], grid_);
        TileBins bins = tile_bins(grid_, list_.rects.span(), list_.order);
        stats.tile_entries = bins.entries.size();
        stats.bin_ms = clock.lap_ms();
        return bins;
    }

    const SurfelTree& tree_;
    PixelView view_;
    PixelWindow grid_;
    const SampleMask* only_;
    bool clean_outlines_;
    DrawList<Degree> list_;
    TileBins bins_;
};

ForwardPicture::ForwardPicture(const SurfelTree& tree, const RenderRequest& request,
                               const SampleMask* only)
    : wanted_(request.wanted) {
    Clock clock;
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    const PixelWindow grid = whole_tiles(request.resolved_window());
    CutCounts met;
    std::vector<std::uint32_t> visited;
    if (request.on_met) met.visited = &visited;
    const auto cut = lod_cut(tree, view, grid, {request.lod_px, request.loose}, met);
    stats_.nodes_visited = met.nodes_visited;
    stats_.loose_hidden = met.loose_hidden;
    if (request.on_met) request.on_met(visited);
    stats_.cut_ms = clock.lap_ms();
    LeafHessians* hessians = nullptr;
    if (wanted_ & kHessianChannels) {
        if (!request.hessians) own_hessians_ = std::make_unique<LeafHessians>(tree);
        hessians = request.hessians ? request.hessians : own_hessians_.get();
        hessians->prepare(cut, request.on_met);
        stats_.decode_ms = clock.lap_ms();
    }
    const auto make = [&]<int Degree>() -> std::unique_ptr<Ready> {
        return std::make_unique<ReadyOf<Degree>>(tree, view, grid, cut, hessians, only,
                                                 request.clean_outlines, stats_);
    };
    const int degree = tree.header().degree;
    ready_ = degree <= 1   ? make.operator()<1>()
             : degree == 2 ? make.operator()<2>()
                           : make.operator()<3>();
}

ForwardPicture::~ForwardPicture() = default;

RenderStats ForwardPicture::draw(const PixelWindow& window, GBuffer& out) const {
    Clock clock;
    RenderStats stats = stats_;
    out.resize(window.width, window.height, wanted_);
    put_counts(ready_->draw(window, out), stats);
    stats.draw_ms = clock.lap_ms();
    stats.total_ms = stats.cut_ms + stats.decode_ms + stats.bin_ms + stats.draw_ms;
    return stats;
}

}  // namespace slim
