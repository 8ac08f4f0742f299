// The points of a cloud as oriented discs (Embree) beside SLIM's forward renderer:
// error against time, one view.
//
//   peer_discs SHAPE CLOUD.ply SIZE REPEAT THREADS MODEL.slim...
//
// SHAPE, a closed one, is what `slim scan` scanned. Radius of a disc: 1.5 spacings, sqrt(area / n)
// with the area of the ellipsoid in the shape's box. A frame ends with a depth and a normal a
// pixel. Prints one JSON object of rows, discs and degree_D_lod_N: what, lod, ms (median), hits,
// and over the hits the angle of the normal to that of the surface's nearest point in degrees (RMS,
// median), the RMS distance over the diagonal, and astray, the hits without a nearest point (at
// creases), which are left out.
#include "formats/model_file.h"
#include "formats/point_source.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/parallel.h"
#include "slim/shapes/foot_point.h"

#include <nlohmann/json.hpp>

#include <embree3/rtcore.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace slim {
namespace {

constexpr int kPacket = 16;

struct Job {
    const Shape& shape;
    int size, repeat;
    Camera camera;
    PixelView view;
    double diagonal;
};

/// Position, frame of the shape, and normal of each pixel; NaN without a hit.
struct Seen {
    std::vector<Vec3f> normal;
    std::vector<Vec3d> point;
};

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

template <class Draw>
double median_ms(int repeat, const Draw& draw) {
    std::vector<double> times;
    for (int k = 0; k < repeat; ++k) {
        const auto start = std::chrono::steady_clock::now();
        draw();
        times.push_back(milliseconds_since(start));
    }
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

nlohmann::ordered_json row_of(const Job& job, const std::string& what, double lod, double ms,
                              const Seen& seen) {
    double sq_angle = 0, sq_distance = 0;
    std::vector<double> angles;
    std::size_t astray = 0;
    for (std::size_t i = 0; i < seen.point.size(); ++i) {
        if (std::isnan(seen.point[i].x)) continue;
        const FootPoint foot = foot_point(job.shape, seen.point[i]);
        if (!foot.converged) {
            ++astray;
            continue;
        }
        const Vec3d truth = surface_point(job.shape.jet(foot.point)).normal;
        const double cos =
            std::clamp(std::abs(dot(truth, normalized(to_double(seen.normal[i])))), 0.0, 1.0);
        const double angle = std::acos(cos) * 180 / std::numbers::pi;
        sq_angle += angle * angle, sq_distance += foot.signed_distance * foot.signed_distance;
        angles.push_back(angle);
    }
    if (angles.empty()) angles.push_back(std::nan(""));
    const std::size_t n = angles.size();
    std::nth_element(angles.begin(), angles.begin() + static_cast<std::ptrdiff_t>(n / 2),
                     angles.end());
    const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(n)); };
    return {{"what", what},
            {"lod", lod},
            {"ms", ms},
            {"hits", n + astray},
            {"normal_deg", rms(sq_angle)},
            {"normal_median_deg", angles[n / 2]},
            {"distance", rms(sq_distance) / job.diagonal},
            {"astray", astray}};
}

Seen nothing_seen(const Job& job) {
    const auto n = static_cast<std::size_t>(job.size) * static_cast<std::size_t>(job.size);
    return {std::vector<Vec3f>(n), std::vector<Vec3d>(n, Vec3d{std::nan(""), 0, 0})};
}

/// Embree's scene of one disc a point.
class Discs {
public:
    Discs(const std::vector<Vec3d>& position, const std::vector<Vec3f>& normal, double radius)
        : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        RTCGeometry discs = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
        auto* points = static_cast<float*>(
            rtcSetNewGeometryBuffer(discs, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                                    4 * sizeof(float), position.size()));
        auto* normals = static_cast<float*>(
            rtcSetNewGeometryBuffer(discs, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3,
                                    3 * sizeof(float), position.size()));
        for (std::size_t i = 0; i < position.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                points[4 * i + k] = static_cast<float>(position[i][k]);
                normals[3 * i + k] = normal[i][k];
                points[4 * i + 3] = static_cast<float>(radius);
            }
        rtcCommitGeometry(discs);
        rtcAttachGeometry(scene_, discs);
        rtcReleaseGeometry(discs);
        rtcCommitScene(scene_);
    }
    ~Discs() { rtcReleaseScene(scene_), rtcReleaseDevice(device_); }
    Discs(const Discs&) = delete;
    Discs& operator=(const Discs&) = delete;

    /// A depth (distance from the eye, infinite without a hit) and a normal a pixel.
    void draw(const Job& job, std::vector<float>& depth, std::vector<Vec3f>& normal) const {
        parallel_blocks(static_cast<std::size_t>(job.size), 4,
                        [&](std::size_t begin, std::size_t end) {
                            for (std::size_t y = begin; y < end; ++y)
                                for (int x = 0; x < job.size; x += kPacket)
                                    draw_packet(job, x, static_cast<int>(y), depth, normal);
                        });
    }

private:
    void draw_packet(const Job& job, int x, int y, std::vector<float>& depth,
                     std::vector<Vec3f>& normal) const {
        alignas(64) RTCRayHit16 r;
        alignas(64) int valid[kPacket];
        const Vec3f eye = to_float(job.view.eye), right = to_float(job.view.right),
                    down = to_float(job.view.down), forward = to_float(job.view.forward);
        const auto focal = static_cast<float>(job.view.focal_px);
        for (int k = 0; k < kPacket; ++k) {
            valid[k] = x + k < job.size ? -1 : 0;
            const float s =
                (static_cast<float>(x + k) + 0.5f - static_cast<float>(job.view.center_x)) / focal;
            const float t =
                (static_cast<float>(y) + 0.5f - static_cast<float>(job.view.center_y)) / focal;
            const Vec3f d = right * s + down * t + forward;
            r.ray.org_x[k] = eye.x, r.ray.org_y[k] = eye.y, r.ray.org_z[k] = eye.z;
            r.ray.dir_x[k] = d.x, r.ray.dir_y[k] = d.y, r.ray.dir_z[k] = d.z;
            r.ray.tnear[k] = 0, r.ray.tfar[k] = std::numeric_limits<float>::infinity();
            r.ray.time[k] = 0, r.ray.mask[k] = ~0u, r.ray.flags[k] = 0;
            r.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        }
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect16(valid, scene_, &context, &r);
        const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(job.size);
        for (int k = 0; k < kPacket && x + k < job.size; ++k) {
            const std::size_t i = row + static_cast<std::size_t>(x + k);
            depth[i] = r.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID
                           ? std::numeric_limits<float>::infinity()
                           : r.ray.tfar[k];
            normal[i] = {r.hit.Ng_x[k], r.hit.Ng_y[k], r.hit.Ng_z[k]};
        }
    }

    RTCDevice device_;
    RTCScene scene_;
};

/// Of n points on the ellipsoid in the shape's box (Thomsen's formula):
/// within a tenth for the closed shapes.
double spacing_of(const Shape& shape, std::size_t n) {
    const Vec3d half = (shape.bounds.hi - shape.bounds.lo) * 0.5;
    const double p = 1.6075, a = std::pow(half.x * half.y, p), b = std::pow(half.y * half.z, p),
                 c = std::pow(half.z * half.x, p);
    const double area = 4 * std::numbers::pi * std::pow((a + b + c) / 3, 1 / p);
    return std::sqrt(area / static_cast<double>(n));
}

nlohmann::ordered_json draw_discs(const Job& job, const std::string& path) {
    std::vector<Vec3d> position;
    std::vector<Vec3f> normal;
    const auto source = open_cloud(path);
    for (PointChunk chunk; source->read(chunk, 1 << 16);) {
        position.insert(position.end(), chunk.position.begin(), chunk.position.end());
        normal.insert(normal.end(), chunk.normal.begin(), chunk.normal.end());
    }
    const auto start = std::chrono::steady_clock::now();
    const Discs discs(position, normal, 1.5 * spacing_of(job.shape, position.size()));
    std::fprintf(stderr, "Embree: %zu discs, %.1f ms to build\n", position.size(),
                 milliseconds_since(start));
    Seen seen = nothing_seen(job);
    std::vector<float> depth(seen.point.size());
    const double ms = median_ms(job.repeat, [&] { discs.draw(job, depth, seen.normal); });
    for (std::size_t i = 0; i < depth.size(); ++i) {
        if (std::isinf(depth[i])) continue;
        const auto x = static_cast<double>(i % static_cast<std::size_t>(job.size)) + 0.5;
        const auto y = static_cast<double>(i / static_cast<std::size_t>(job.size)) + 0.5;
        seen.point[i] = job.view.point_at(x, y, static_cast<double>(depth[i]));
    }
    return row_of(job, "Embree discs", 0, ms, seen);
}

/// Adds the model's row.
void draw_model(const Job& job, const std::string& path, double lod, nlohmann::ordered_json& rows) {
    const ModelFile file = ModelFile::open(path);
    const SurfelTree tree = file.tree();
    const Vec3d origin = tree.header().origin;
    RenderRequest request{job.camera, job.size, job.size, kDepthChannel | kNormalChannel,
                          lod,        {},       false};
    request.camera.eye = request.camera.eye - origin,
    request.camera.target = request.camera.target - origin;
    GBuffer out;
    const double ms = median_ms(job.repeat, [&] { render_forward(tree, request, out); });
    Seen seen = nothing_seen(job);
    for (std::size_t i = 0; i < out.n_pixels(); ++i) {
        if (!out.hit[i]) continue;
        const auto x = static_cast<double>(i % static_cast<std::size_t>(job.size)) + 0.5;
        const auto y = static_cast<double>(i / static_cast<std::size_t>(job.size)) + 0.5;
        seen.point[i] = job.view.point_at(x, y, static_cast<double>(out.depth[i]));
        seen.normal[i] = {out.normal[0][i], out.normal[1][i], out.normal[2][i]};
    }
    const std::string degree = std::to_string(tree.header().degree);
    rows["degree_" + degree + "_lod_" + std::to_string(static_cast<int>(lod))] =
        row_of(job, "degree " + degree, lod, ms, seen);
}

int run(int argc, char** argv) {
    const Shape& shape = find_shape(argv[1]);
    const int size = std::atoi(argv[3]);
    const ThreadLimit limit(std::atoi(argv[5]));
    const Camera camera = named_camera("iso", shape.bounds, 1.0, {});
    const Job job{shape, size, std::atoi(argv[4]), camera, pixel_view(camera, size, size),
                  length(shape.bounds.hi - shape.bounds.lo)};
    nlohmann::ordered_json rows;
    rows["discs"] = draw_discs(job, argv[2]);
    for (int k = 6; k < argc; ++k)
        for (const double lod : {1.0, 2.0, 4.0, 8.0, 16.0}) draw_model(job, argv[k], lod, rows);
    std::printf("%s\n", rows.dump().c_str());
    return 0;
}

}  // namespace
}  // namespace slim

int main(int argc, char** argv) {
    if (argc < 7) {
        std::fprintf(stderr,
                     "usage: peer_discs SHAPE CLOUD.ply SIZE REPEAT THREADS MODEL.slim...\n");
        return 2;
    }
    try {
        return slim::run(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "peer_discs: %s\n", e.what());
        return 1;
    }
}
