// Crest lines of models against the exact ones of the shape that was scanned,
// as one view shows them.
//
//   bench_crest_truth SHAPE CAMERA SIZE [MODEL.slim...]
//
// SHAPE, a closed one, is what `slim scan` scanned. The first row, `exact`, extracts the lines of
// exact curvatures: what is wrong there is the extraction's own. Of quadratic surfels, whose third
// derivatives are zero, e is the difference of k over blur_reach pixels to either side, and the
// command refuses them. Prints one JSON object of rows:
//
//   lines_px             length of the lines extracted, pixels
//   exact_px, sharp_px   of all exact ones, and of those whose sharpness is 0.3 or more,
//                        which are to be drawn
//   median_px, p95_px, hausdorff_px   distances of the lines extracted from exact ones of their
//                                     kind, by length
//   false_px, missed_px  length extracted more than `near_px` (5 in a picture of 1000, in
//                        proportion) from any exact line, and of sharp exact lines as far from any
//                        extracted one
//   frame_ms, lines_ms   drawing and extraction, least of three
#include "formats/model_file.h"
#include "raytrace/lines/extract.h"
#include "raytrace/lines/sheets.h"
#include "raytrace/project/forward_renderer.h"
#include "tests/bench/exact_crest.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace slim::bench {
namespace {

constexpr std::array kCrests{LineKind::ridge, LineKind::valley};
constexpr double kSharp = 0.3;  // as line_rules has it

struct Job {
    const Shape& shape;
    Camera camera;
    int size;
    PixelView view;
    double near_px;
    std::vector<CrestSample> exact;
};

template <class Work>
double least_ms(const Work& work) {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        const auto start = std::chrono::steady_clock::now();
        work();
        least = std::min(least, std::chrono::duration<double, std::milli>(
                                    std::chrono::steady_clock::now() - start)
                                    .count());
    }
    return least;
}

/// Pieces of half a pixel or less.
std::vector<CrestSample> samples_of(const std::vector<FeatureLine>& lines) {
    std::vector<CrestSample> out;
    for (const FeatureLine& line : lines)
        line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
            const double dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y),
                         px = std::hypot(dx, dy);
            const int n = std::max(1, static_cast<int>(std::ceil(2 * px)));
            for (int k = 0; k < n; ++k) {
                const double s = (k + 0.5) / n;
                out.push_back({line.kind == LineKind::ridge, static_cast<double>(a.x) + s * dx,
                               static_cast<double>(a.y) + s * dy, px / n, 0});
            }
        });
    return out;
}

double distance(const CrestSample& from, const std::vector<CrestSample>& to) {
    double least = std::numeric_limits<double>::infinity();
    for (const CrestSample& q : to)
        if (q.ridge == from.ridge)
            least =
                std::min(least, (q.x - from.x) * (q.x - from.x) + (q.y - from.y) * (q.y - from.y));
    return std::sqrt(least);
}

nlohmann::ordered_json compare(const Job& job, const std::vector<FeatureLine>& lines) {
    const std::vector<CrestSample> found = samples_of(lines);
    std::vector<std::pair<double, double>> far;  // distance, length
    double lines_px = 0, exact_px = 0, sharp_px = 0, false_px = 0, missed_px = 0;
    for (const CrestSample& p : found) {
        const double d = distance(p, job.exact);
        lines_px += p.px, false_px += d > job.near_px ? p.px : 0;
        far.emplace_back(d, p.px);
    }
    for (const CrestSample& p : job.exact) {
        exact_px += p.px;
        if (p.sharpness < kSharp) continue;
        sharp_px += p.px;
        missed_px += distance(p, found) > job.near_px ? p.px : 0;
    }
    std::sort(far.begin(), far.end());
    const auto below = [&](double share) -> nlohmann::ordered_json {
        double sum = 0;
        for (const auto& [d, px] : far)
            if ((sum += px) >= share * lines_px)
                return std::isfinite(d) ? nlohmann::ordered_json(d) : nlohmann::ordered_json();
        return nullptr;
    };
    const bool any = !far.empty() && std::isfinite(far.back().first);
    return {
        {"lines_px", lines_px},
        {"exact_px", exact_px},
        {"sharp_px", sharp_px},
        {"median_px", below(0.5)},
        {"p95_px", below(0.95)},
        {"hausdorff_px", any ? nlohmann::ordered_json(far.back().first) : nlohmann::ordered_json()},
        {"near_px", job.near_px},
        {"false_px", false_px},
        {"missed_px", missed_px}};
}

/// e by differences of k in the picture, of models without third derivatives.
void difference(const PixelView& view, GBuffer& b) {
    const double reach = static_cast<double>(blur_reach(b.width, b.height));
    const auto at = [](const auto& planes, std::size_t i) {
        return Vec3f{planes[0][i], planes[1][i], planes[2][i]};
    };
    for (std::size_t i = 0; i < b.n_pixels(); ++i) {
        if (!b.hit[i]) continue;
        const Vec3f q = at(b.position, i), t1 = at(b.direction, i);
        const double depth = view.camera_from_local(to_double(q)).z;
        const double scale = view.orthographic ? view.px_per_unit : view.focal_px / depth;
        const auto slope = [&](const std::vector<float>& k, const Vec3f& t) {
            const Vec3d along = view.rotate_to_camera(to_double(t));
            const double px = scale * std::hypot(along.x, along.y);
            if (!(px > 0)) return 0.0f;
            const double x = static_cast<double>(i % static_cast<std::size_t>(b.width)),
                         y = static_cast<double>(i / static_cast<std::size_t>(b.width));
            std::array<float, 2> ends{};
            std::array<Vec3f, 2> places{};
            for (std::size_t side = 0; side < 2; ++side) {
                const double way = (side == 0 ? -1 : 1) * reach * scale / px;
                const auto u = static_cast<int>(std::lround(x + way * along.x)),
                           v = static_cast<int>(std::lround(y + way * along.y));
                if (u < 0 || v < 0 || u >= b.width || v >= b.height || !b.hit[b.index(u, v)])
                    return 0.0f;
                ends[side] = k[b.index(u, v)], places[side] = at(b.position, b.index(u, v));
            }
            const float run = dot(places[1] - places[0], t);
            return run > 0 ? (ends[1] - ends[0]) / run : 0.0f;
        };
        b.third[0][i] = slope(b.k1, t1);
        b.third[3][i] = slope(b.k2, cross(at(b.normal, i), t1));
    }
}

nlohmann::ordered_json row_of(const Job& job, const std::string& what, const GBuffer& buffer,
                              const PixelView& view, double diagonal, double frame_ms) {
    std::vector<FeatureLine> lines;
    const double lines_ms = least_ms([&] {
        lines = extract_lines({buffer, view, diagonal, 3}, kCrests);
    });
    nlohmann::ordered_json row = compare(job, lines);
    row["what"] = what, row["frame_ms"] = frame_ms, row["lines_ms"] = lines_ms;
    return row;
}

nlohmann::ordered_json row_of_model(const Job& job, const std::string& path) {
    const ModelFile file = ModelFile::open(path);
    const SurfelTree tree = file.tree();
    const Vec3d origin = tree.header().origin;
    RenderRequest request;
    request.camera = job.camera, request.width = request.height = job.size;
    request.camera.eye = job.camera.eye - origin,
    request.camera.target = job.camera.target - origin;
    request.wanted = line_channels(kCrests, 3);
    GBuffer buffer;
    const double ms = least_ms([&] { render_forward(tree, request, buffer); });
    const PixelView view = pixel_view(request.camera, job.size, job.size);
    if (tree.header().degree < 3) difference(view, buffer);
    return row_of(job, path, buffer, view, tree.header().diagonal, ms);
}

int run(int argc, char** argv) {
    const Shape& shape = find_shape(argv[1]);
    const int size = std::atoi(argv[3]);
    const Camera camera = named_camera(argv[2], shape.bounds, 1.0, {.up = UpAxis::z});
    Job job{shape, camera, size, pixel_view(camera, size, size), 5e-3 * size, {}};
    const GBuffer exact = exact_buffer(shape, job.view, size, size);
    job.exact = exact_crest_lines(shape, job.view, exact);
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    rows.push_back(
        row_of(job, "exact", exact, job.view, length(shape.bounds.hi - shape.bounds.lo), 0));
    for (int k = 4; k < argc; ++k) rows.push_back(row_of_model(job, argv[k]));
    std::printf("%s\n", rows.dump().c_str());
    return 0;
}

}  // namespace
}  // namespace slim::bench

int main(int argc, char** argv) {
    if (argc < 4 || std::atoi(argv[3]) < 1) {
        std::fprintf(stderr, "usage: bench_crest_truth SHAPE CAMERA SIZE [MODEL.slim...]\n");
        return 2;
    }
    try {
        return slim::bench::run(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "bench_crest_truth: %s\n", e.what());
        return 1;
    }
}
