#include "raytrace/trace/trace_renderer.h"

#include "raytrace/intersect/curvature_kernel.h"
#include "raytrace/intersect/third_order_kernel.h"
#include "raytrace/trace/primary_rays.h"

#include <bit>
#include <chrono>
#include <vector>

namespace slim {
namespace {

struct Counts {
    TraceCounts trace;
    std::uint64_t covered = 0, unblended = 0;
};

Derivatives derivatives_for(const GBuffer& out, int degree) {
    if (out.has(kThirdOrderChannel) && degree >= 3) return Derivatives::third;
    return out.has_any(kHessianChannels) ? Derivatives::second : Derivatives::first;
}

int degree_of(const TraceScene& scene) {
    int degree = 1;
    for (const ScenePart& part : scene.parts())
        degree = std::max(degree, part.tree->header().degree);
    return degree;
}

/// The pixels of a packet's hits, one by one.
struct Writer {
    const PixelView& view;
    const TraceScene& scene;
    const PixelBlock& block;
    const SurfaceHits& hits;
    GBuffer& out;
    TracedPlanes* planes;

    template <class Write>
    void for_hits(Write&& write) const {
        for (std::uint64_t bits = lane_bits(hits.hit()); bits != 0; bits &= bits - 1) {
            const int lane = std::countr_zero(bits);
            write(lane, static_cast<std::size_t>(lane), block.index(lane));
        }
    }

    void place() const {
        for_hits([&](int lane, std::size_t, std::size_t pixel) {
            out.hit[pixel] = 1;
            const Vec3d p = scene.frame().to_job(to_double(hits.point.at(lane)) +
                                                 to_double(hits.point_low.at(lane)));
            const Vec3f position = to_float(p), normal = hits.normal.at(lane);
            if (out.has(kDepthChannel))
                out.depth[pixel] = static_cast<float>(dot(p - view.eye, view.forward));
            if (planes && !planes->position_low[0].empty())
                keep_low(pixel, p - to_double(position));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (out.has(kPositionChannel)) out.position[axis][pixel] = position[axis];
                if (out.has(kNormalChannel)) out.normal[axis][pixel] = normal[axis];
            }
        });
    }

    void keep_low(std::size_t pixel, const Vec3d& low) const {
        for (std::size_t axis = 0; axis < 3; ++axis)
            planes->position_low[axis][pixel] = static_cast<float>(low[axis]);
    }

    void leave() const {
        for_hits([&](int, std::size_t k, std::size_t pixel) {
            planes->clearance[pixel] = hits.clearance[k];
            if (!planes->model.empty())
                planes->model[pixel] = static_cast<std::uint16_t>(hits.model[k]);
        });
    }

    void fit() const {
        for_hits([&](int, std::size_t k, std::size_t pixel) {
            const std::uint32_t node = scene.models()[hits.model[k]].records[hits.record[k]].node;
            const TreeNode& of = scene.parts()[hits.model[k]].tree->node(node);
            if (out.has(kSurfelIdChannel)) out.surfel_id[pixel] = node;
            if (out.has(kFitErrorChannel)) out.fit_error[pixel] = of.fit_error;
            if (out.has(kLevelChannel)) out.level[pixel] = of.level;
            if (out.has(kCoverageChannel)) out.coverage[pixel] = hits.sums.weight[k];
            if (out.has(kCountChannel))
                out.count[pixel] = static_cast<std::uint32_t>(hits.sums.count[k]);
        });
    }

    /// Pixels that kept q^ have no Hessian: all of these stay 0.
    template <class Write>
    void for_blended(Write&& write) const {
        for_hits([&](int lane, std::size_t k, std::size_t pixel) {
            if (hits.sums.weight[k] > 0) write(lane, k, pixel);
        });
    }

    void curvature() const {
        const LanesOfVec& g = hits.sums.gradient;
        const auto c = curvature_lanes<FloatV>(g.x, g.y, g.z, hits.sums.hessian);
        const auto per_unit = static_cast<float>(1 / scene.frame().unit);
        for_blended([&](int, std::size_t k, std::size_t pixel) {
            if (out.has(kK1Channel)) out.k1[pixel] = c.k1[k] * per_unit;
            if (out.has(kK2Channel)) out.k2[pixel] = c.k2[k] * per_unit;
            if (out.has(kMeanChannel)) out.mean[pixel] = c.mean[k] * per_unit;
            if (out.has(kGaussChannel)) out.gauss[pixel] = c.gauss[k] * per_unit * per_unit;
        });
    }

    void directions(bool third) const {
        const LanesOfVec& g = hits.sums.gradient;
        const auto p = principal_lanes<FloatV>(g.x, g.y, g.z, hits.sums.hessian);
        if (out.has(kDirectionChannel))
            for_blended([&](int, std::size_t k, std::size_t pixel) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    out.direction[axis][pixel] = p.t1[axis][k];
            });
        if (!third) return;
        const auto q = third_order_lanes<FloatV>(p, hits.sums.hessian, hits.sums.third);
        const auto per_unit = static_cast<float>(1 / scene.frame().unit);
        for_blended([&](int, std::size_t k, std::size_t pixel) {
            for (std::size_t n = 0; n < 4; ++n) out.third[n][pixel] = q[n][k] * per_unit * per_unit;
        });
    }
};

void draw_block(const TraceScene& scene, const PixelView& view, const PixelBlock& block,
                Derivatives wanted, bool clean_outlines, GBuffer& out, TracedPlanes* planes,
                Counts& counts) {
    const RayPacket rays = primary_rays(view, scene.frame(), block);
    if (stdx::none_of(rays.active())) return;
    const SurfaceHits hits = scene.surface(rays, wanted, counts.trace, clean_outlines);
    const auto hit = hits.hit();
    if (stdx::none_of(hit)) return;
    counts.covered += static_cast<std::uint64_t>(stdx::popcount(hit));
    counts.unblended +=
        static_cast<std::uint64_t>(stdx::popcount(hit && !(hits.sums.weight > 0.0f)));
    const Writer write{view, scene, block, hits, out, planes};
    write.place();
    if (planes) write.leave();
    if (out.has_any(kSurfelIdChannel | kFitErrorChannel | kLevelChannel | kCoverageChannel |
                    kCountChannel))
        write.fit();
    if (out.has_any(kCurvatureChannel)) write.curvature();
    if (out.has_any(kDirectionChannel | kThirdOrderChannel))
        write.directions(wanted == Derivatives::third);
}

}  // namespace

RenderStats render_traced(const TraceScene& scene, const RenderRequest& request, GBuffer& out,
                          TracedPlanes* planes, const SampleMask* only) {
    const auto start = std::chrono::steady_clock::now();
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    const PixelWindow window = request.resolved_window();
    out.reset(window.width, window.height, request.wanted);
    if (planes) {
        planes->clearance.assign(out.n_pixels(), 0.0f);
        planes->model.assign(scene.models().size() > 1 ? out.n_pixels() : 0, 0);
        for (auto& plane : planes->position_low)
            plane.assign(scene.is_wide() ? out.n_pixels() : 0, 0.0f);
    }
    const Derivatives wanted = derivatives_for(out, degree_of(scene));
    if (wanted > Derivatives::first)
        for (const TraceModel& model : scene.models()) model.hessians->prepare_all();
    std::vector<Counts> rows(n_block_rows(window));
    for_blocks(window, [&](std::size_t row, const PixelBlock& block) {
        draw_block(scene, view, block, wanted, request.clean_outlines, out, planes, rows[row]);
    }, only);
    RenderStats stats;
    TraceCounts sum;
    for (const Counts& c : rows) {
        sum += c.trace;
        stats.covered_pixels += c.covered, stats.unblended_pixels += c.unblended;
    }
    stats.nodes_visited = sum.nodes_visited, stats.root_tests = sum.root_tests,
    stats.distance_tests = sum.distance_tests;
    stats.surfels_drawn = scene.n_surfels();
    for (const TraceModel& model : scene.models()) stats.loose_hidden += model.loose_hidden;
    stats.draw_ms = stats.total_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return stats;
}

}  // namespace slim
