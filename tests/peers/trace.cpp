// Rays at a model's surfels through SLIM's own tree of boxes and through Embree's, stage 1 only,
// in one run.
//
//   peer_trace MODEL.slim SIZE REPEAT THREADS [VIEW [QUALITY]]
//
// Embree 3 has the surfels as user geometry: the same boxes, the same kernel on the same lanes (a
// packet of as many rays as there are), called for each surfel whose box a packet meets. QUALITY is
// Embree's of building: low, medium or high (default). Primary rays of SIZE x SIZE pixels, then
// rays from their hits to the two studio lights. Prints one JSON object: medians in ms of REPEAT
// frames by turns (rays: making them, in all of the others), of both builders over the same boxes,
// and the rays that differ.
#include "formats/model_file.h"
#include "raytrace/camera.h"
#include "raytrace/light_rig.h"
#include "raytrace/trace/light_tracer.h"
#include "raytrace/trace/primary_rays.h"
#include "raytrace/trace/trace_scene.h"
#include "slim/base/parallel.h"
#include "tests/peers/embree_surfels.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace slim {
namespace {

double ms_of(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

/// The same calls of SLIM's.
struct OwnTree {
    const TraceScene& scene;

    FirstHits first_hits(const RayPacket& rays) const {
        TraceCounts counts;
        std::array<std::uint32_t, kLanes> model{};
        return scene.first_hits(rays, model, counts);
    }
    FloatV::mask_type unblocked(const RayPacket& rays) const {
        TraceCounts counts;
        return scene.unblocked(rays, counts);
    }
};

/// Makes rays and sends them nowhere.
struct NoTree {
    FirstHits first_hits(const RayPacket& rays) const {
        FirstHits hits;
        hits.t = rays.origin.x + rays.direction.y, hits.gradient = LanesOfVec(Vec3f{});
        return hits;
    }
    FloatV::mask_type unblocked(const RayPacket& rays) const {
        return rays.origin.x + rays.direction.y > rays.far;
    }
};

/// What shadow rays leave, one block of pixels.
struct Points {
    LanesOfVec point, normal, outward;
    FloatV clearance;
    FloatV::mask_type on;
};

struct View {
    const TraceScene& scene;
    PixelView pixels;
    PixelWindow window;
    std::vector<Vec3f> lights;

    std::size_t blocks_a_row() const {
        return static_cast<std::size_t>((window.width + kPacketWidth - 1) / kPacketWidth);
    }
    std::size_t n_blocks() const { return n_block_rows(window) * blocks_a_row(); }
    std::size_t index(const PixelBlock& b) const {
        return static_cast<std::size_t>(b.y / kPacketHeight) * blocks_a_row() +
               static_cast<std::size_t>(b.x / kPacketWidth);
    }
};

template <class Tree>
void draw(const View& view, const Tree& tree, std::vector<FirstHits>& out) {
    for_blocks(view.window, [&](std::size_t, const PixelBlock& block) {
        out[view.index(block)] =
            tree.first_hits(primary_rays(view.pixels, view.scene.frame(), block));
    });
}

/// Bits of the lanes that each light reaches.
template <class Tree>
void light(const View& view, const Tree& tree, const std::vector<Points>& points,
           std::vector<std::uint64_t>& out) {
    for_blocks(view.window, [&](std::size_t, const PixelBlock& block) {
        const Points& at = points[view.index(block)];
        if (stdx::none_of(at.on)) return;
        for (std::size_t i = 0; i < view.lights.size(); ++i) {
            RayPacket rays;
            rays.origin = at.point + at.normal * at.clearance,
            rays.direction = LanesOfVec(view.lights[i]);
            rays.far = select<FloatV>(at.on && at.normal.dot(rays.direction) > 0.0f, FloatV(kFar),
                                      FloatV(-1.0f));
            rays.normal = at.outward, rays.leaves_surface = true;
            out[view.index(block) * view.lights.size() + i] =
                stdx::any_of(rays.active()) ? lane_bits(tree.unblocked(rays)) : 0;
        }
    });
}

std::vector<Points> points_of(const View& view, const std::vector<FirstHits>& hits) {
    std::vector<Points> out(view.n_blocks());
    for_blocks(view.window, [&](std::size_t, const PixelBlock& block) {
        const FirstHits& h = hits[view.index(block)];
        const RayPacket rays = primary_rays(view.pixels, view.scene.frame(), block);
        Points& p = out[view.index(block)];
        p.on = rays.active() && h.t < kFar;
        p.point = rays.origin + rays.direction * select<FloatV>(p.on, h.t, FloatV(0.0f));
        p.outward = h.gradient.unit();
        p.normal = select_vec(p.outward.dot(rays.direction) > 0.0f, -p.outward, p.outward);
        p.clearance = FloatV(kPlaceRounding);
        for (std::uint64_t bits = lane_bits(p.on); bits != 0; bits &= bits - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(bits));
            p.clearance[k] += view.scene.models()[0]
                                  .records[std::bit_cast<std::uint32_t>(float(h.record[k]))]
                                  .clearance;
        }
    });
    return out;
}

struct Apart {
    std::uint64_t rays = 0, hits = 0, hit = 0, record = 0, shadow_rays = 0, shadow = 0;
    float distance = 0;

    void count_hits(const View& view, const std::vector<FirstHits>& a,
                    const std::vector<FirstHits>& b) {
        for (std::size_t i = 0; i < view.n_blocks(); ++i)
            for (std::size_t k = 0; k < kLanes; ++k) {
                const float s = a[i].t[k], t = b[i].t[k];
                ++rays, hits += s < kFar;
                hit += (s < kFar) != (t < kFar);
                if (!(s < kFar && t < kFar)) continue;
                record += std::bit_cast<std::uint32_t>(float(a[i].record[k])) !=
                          std::bit_cast<std::uint32_t>(float(b[i].record[k]));
                distance = std::max(distance, std::abs(s - t));
            }
    }
    void count_shadows(const View& view, const std::vector<Points>& points,
                       const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Points& p = points[i / view.lights.size()];
            const LanesOfVec toward(view.lights[i % view.lights.size()]);
            shadow_rays +=
                static_cast<std::uint64_t>(stdx::popcount(p.on && p.normal.dot(toward) > 0.0f));
            shadow += static_cast<std::uint64_t>(std::popcount(a[i] ^ b[i]));
        }
    }
};

/// Boxes in the order of the model's file, as a builder gets them.
std::vector<BoxF> boxes_as_filed(const TraceModel& model) {
    std::vector<const TraceRecord*> records;
    for (const TraceRecord& r : model.records) records.push_back(&r);
    std::sort(records.begin(), records.end(), [](auto* a, auto* b) { return a->node < b->node; });
    std::vector<BoxF> out;
    for (const TraceRecord* r : records) out.push_back(hit_box(*r));
    return out;
}

View view_of(const TraceScene& scene, const ModelHeader& header, const char* name, int size) {
    const Camera camera = named_camera(name, header.bounds, 1.0, {});
    View view{scene, pixel_view(camera, size, size), {0, 0, size, size}, {}};
    const ShadeView shade{view.pixels.right, -view.pixels.down, -view.pixels.forward, 1, 1, false};
    for (const LightSource& light : studio_rig(shade).lights)
        view.lights.push_back(to_float(light.toward));
    return view;
}

/// Times of both trees, in milliseconds; medians of some runs in turn.
struct BuildTimes {
    std::vector<double> own, embree;

    BuildTimes(const TraceModel& model, int repeat, int n_threads, RTCBuildQuality quality) {
        const std::vector<BoxF> filed = boxes_as_filed(model);
        for (int k = 0; k < repeat; ++k) {
            own.push_back(ms_of([&] { build_bvh(filed); }));
            embree.push_back(ms_of([&] { EmbreeSurfels(model, filed, n_threads, quality); }));
        }
    }
    nlohmann::ordered_json to_json() const {
        return {{"own_build_ms", median(own)}, {"embree_build_ms", median(embree)}};
    }
};

/// Rays and shadow rays of a view through both trees and through none, and where the trees' answers
/// are apart.
class ViewTimes {
public:
    ViewTimes(const View& view, const OwnTree& own, const EmbreeSurfels& embree, int repeat) {
        std::vector<FirstHits> own_hits(view.n_blocks()), embree_hits(own_hits), no_hits(own_hits);
        std::vector<std::uint64_t> own_lit(view.n_blocks() * view.lights.size()),
            embree_lit(own_lit), no_lit(own_lit);
        draw(view, own, own_hits);
        const std::vector<Points> points = points_of(view, own_hits);
        for (int k = 0; k < repeat; ++k) {
            rays_.push_back(ms_of([&] { draw(view, NoTree{}, no_hits); }));
            own_.push_back(ms_of([&] { draw(view, own, own_hits); }));
            embree_.push_back(ms_of([&] { draw(view, embree, embree_hits); }));
            shadow_rays_.push_back(ms_of([&] { light(view, NoTree{}, points, no_lit); }));
            own_shadow_.push_back(ms_of([&] { light(view, own, points, own_lit); }));
            embree_shadow_.push_back(ms_of([&] { light(view, embree, points, embree_lit); }));
        }
        apart_.count_hits(view, own_hits, embree_hits);
        apart_.count_shadows(view, points, own_lit, embree_lit);
    }
    nlohmann::ordered_json to_json() const {
        return {{"rays_ms", median(rays_)},
                {"own_ms", median(own_)},
                {"embree_ms", median(embree_)},
                {"shadow_rays", apart_.shadow_rays},
                {"shadow_rays_ms", median(shadow_rays_)},
                {"own_shadow_ms", median(own_shadow_)},
                {"embree_shadow_ms", median(embree_shadow_)},
                {"hit_differs", apart_.hit},
                {"surfel_differs", apart_.record},
                {"largest_distance", apart_.distance},
                {"shadow_differs", apart_.shadow}};
    }
    std::uint64_t hits() const { return apart_.hits; }

private:
    std::vector<double> rays_, own_, embree_, shadow_rays_, own_shadow_, embree_shadow_;
    Apart apart_;
};

int run(int argc, char** argv) {
    const ModelFile file = ModelFile::open(argv[1]);
    const SurfelTree tree = file.tree();
    const int size = std::atoi(argv[2]), repeat = std::atoi(argv[3]),
              n_threads = std::atoi(argv[4]);
    const RTCBuildQuality quality = embree_quality(argc > 6 ? argv[6] : "high");
    if (size < 1 || repeat < 1 || n_threads < 1)
        throw std::runtime_error("SIZE, REPEAT and THREADS are at least 1");
    const ThreadLimit limit(n_threads);
    const ScenePart part{&tree, {}};
    const TraceScene scene(std::span(&part, 1), false);
    const TraceModel& model = scene.models()[0];
    const View view = view_of(scene, tree.header(), argc > 5 ? argv[5] : "front", size);

    const BuildTimes build(model, repeat, n_threads, quality);
    std::vector<BoxF> boxes;
    for (const TraceRecord& r : model.records) boxes.push_back(hit_box(r));
    const EmbreeSurfels embree(model, boxes, n_threads, quality);
    const ViewTimes seen(view, OwnTree{scene}, embree, repeat);
    nlohmann::ordered_json row{
        {"surfels", model.records.size()}, {"lanes", kLanes}, {"hits", seen.hits()}};
    row.update(build.to_json());
    row.update(seen.to_json());
    std::printf("%s\n", row.dump().c_str());
    return 0;
}

}  // namespace
}  // namespace slim

int main(int argc, char** argv) {
    if (argc < 5 || argc > 7) {
        std::fprintf(stderr, "usage: peer_trace MODEL.slim SIZE REPEAT THREADS [VIEW [QUALITY]]\n");
        return 2;
    }
    try {
        return slim::run(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "peer_trace: %s\n", e.what());
        return 1;
    }
}
