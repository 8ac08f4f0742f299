#include "slim/smooth/smoothing.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/neighbors/key_sort.h"
#include "slim/neighbors/morton.h"
#include "slim/smooth/face_planes.h"
#include "slim/smooth/surface_projector.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kGrain = 2048;
constexpr std::size_t kRun = 32;  ///< points that are asked of the same surfels
constexpr std::size_t kLeastRun = 4;
constexpr std::size_t kMostGathered = 64;  ///< surfels: of more, fewer points are asked

/// Where a point that was at `from` ends, and how far that is, positive along its new normal.
void end_at(const Vec3d& from, Vec3d to, double most, SmoothedPoint& out) {
    const double distance = length(to - from);
    const bool too_far = most > 0 && distance > most;
    if (too_far) to = from + (to - from) * (most / distance);
    out.position = to;
    out.displacement = std::copysign(too_far ? most : distance, dot(to - from, out.normal));
}

/// Turns a point's normal to the surface's by its share of the way, all of it where it has none or
/// one that faces away.
void turn(const Vec3d& to, double share, Vec3d& normal) {
    const bool own = share < 1 && is_finite(normal) && dot(normal, to) > 0;
    normal = own ? normalized(normalized(normal) * (1 - share) + to * share) : to;
}

/// The projector was made ready for a box that holds the point.
SmoothedPoint smooth_point(SurfaceProjector& projector, const SmoothSettings& settings,
                           const Vec3d& from, const Vec3d& own_normal) {
    SmoothedPoint out{from, own_normal};
    if (!is_finite(from)) return out;
    Vec3d p = from, normal = own_normal;
    double share = 1;
    for (int i = 0; i < settings.iterations; ++i) {
        const SurfacePut put =
            i == 0 ? projector.project_gathered(p, normal) : projector.project(p, normal);
        if (!(sq_length(put.normal) > 0)) break;
        if (i == 0) {
            share = projector.share(length(put.point - p));
            out.opposed = put.opposed, out.astray = put.astray;
            out.by_model = projector.by_model(), out.held_back = share < 1;
        }
        p += (put.point - p) * settings.amount;
        normal = put.normal;
        out.moved = true;
    }
    if (!out.moved) return out;
    turn(normal, share, out.normal);
    end_at(from, from + (p - from) * share, settings.most, out);
    return out;
}

/// Points along a Morton curve: one after the other asks the same fits, which then lie in the cache
/// (10 million points of a bumpy sphere in random order take a tenth less time).
KeyedIndices near_after_near(std::span<const Vec3d> positions) {
    Bbox box;
    for (const Vec3d& p : positions)
        if (is_finite(p)) box.extend(p);
    const MortonCurve curve(box);
    KeyedIndices order(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
        order[i] = {is_finite(positions[i]) ? curve.key(positions[i]) : 0,
                    static_cast<std::uint32_t>(i)};
    sort_by_key(order);
    return order;
}

/// A cloud's points and where they end.
struct PointsToSmooth {
    const SmoothSettings& settings;
    std::span<const Vec3d> positions;
    std::span<const Vec3f> normals;  // of each, or none
    std::span<SmoothedPoint> out;
};

/// Points in the order of the curve lie anywhere in memory: they are fetched a run ahead.
void fetch(const PointsToSmooth& cloud, std::span<const KeyedIndex> run) {
    for (const KeyedIndex& k : run) {
        __builtin_prefetch(&cloud.positions[k.index]);
        if (!cloud.normals.empty()) __builtin_prefetch(&cloud.normals[k.index]);
        __builtin_prefetch(&cloud.out[k.index], 1);
    }
}

/// Smooths points that are next along the curve, in two halves where the box about them meets many
/// surfels.
void smooth_run(const PointsToSmooth& cloud, std::span<const KeyedIndex> run,
                SurfaceProjector& projector) {
    Bbox box;
    for (const KeyedIndex& k : run)
        if (is_finite(cloud.positions[k.index])) box.extend(cloud.positions[k.index]);
    projector.gather(box);
    if (projector.n_gathered() > kMostGathered && run.size() > kLeastRun) {
        smooth_run(cloud, run.first(run.size() / 2), projector);
        smooth_run(cloud, run.subspan(run.size() / 2), projector);
        return;
    }
    for (const KeyedIndex& k : run)
        cloud.out[k.index] =
            smooth_point(projector, cloud.settings, cloud.positions[k.index],
                         cloud.normals.empty() ? Vec3d{} : to_double(cloud.normals[k.index]));
}

/// Which way faces should face: the planes' that the model supports.
std::vector<Vec3f> supported_normals(std::span<const FacePlane> planes) {
    std::vector<Vec3f> out(planes.size());
    for (std::size_t f = 0; f < planes.size(); ++f)
        if (planes[f].supported) out[f] = to_float(planes[f].normal);
    return out;
}

/// The mean normal by area of the planes about a vertex, and whether the model supports one of
/// them.
bool normal_of_planes(std::span<const FacePlane> planes, std::span<const std::uint32_t> faces,
                      Vec3d& normal) {
    Vec3d sum;
    bool supported = false;
    for (const std::uint32_t f : faces) {
        sum += planes[f].normal * planes[f].area;
        supported |= planes[f].supported;
    }
    if (sq_length(sum) > 0) normal = normalized(sum);
    return supported;
}

}  // namespace

void smooth_points(const SmoothSurface& surface, const SmoothSettings& settings,
                   std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                   std::span<SmoothedPoint> out) {
    SLIM_CHECK(positions.size(), ==, out.size());
    if (!normals.empty()) SLIM_CHECK(normals.size(), ==, positions.size());
    const KeyedIndices order = near_after_near(positions);
    const PointsToSmooth cloud{settings, positions, normals, out};
    parallel_blocks(positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        SurfaceProjector projector(surface);
        const auto run = [&](std::size_t k) {
            return std::span(order).subspan(k, std::min(kRun, end - k));
        };
        for (std::size_t k = begin; k < end; k += kRun) {
            if (k + kRun < end) fetch(cloud, run(k + kRun));
            smooth_run(cloud, run(k), projector);
        }
    });
}

SmoothedMesh smooth_mesh(const BallIndex& index, const SmoothSettings& settings, Mesh& mesh,
                         const std::function<void(int iteration)>& each_step) {
    const std::vector<Vec3d> from = mesh.position;
    const VertexFaces around(mesh);
    const std::vector<std::uint8_t> held = boundary_vertices(mesh);
    SmoothedMesh out;
    out.vertices.resize(from.size());
    std::vector<Vec3f> toward;
    for (int i = 0; i < settings.iterations; ++i) {
        each_step(i);
        const std::vector<FacePlane> planes = project_faces(mesh, index);
        if (i == 0) {
            toward = supported_normals(planes);
            out.faces_unsupported = static_cast<std::uint64_t>(std::count_if(
                planes.begin(), planes.end(), [](const FacePlane& p) { return !p.supported; }));
        }
        parallel_blocks(from.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                SmoothedPoint& vertex = out.vertices[v];
                Vec3d x = mesh.position[v];
                const bool supported = normal_of_planes(planes, around.of(v), vertex.normal);
                if (!supported || held[v] || !nearest_to_planes(planes, around.of(v), x)) continue;
                mesh.position[v] += (x - mesh.position[v]) * settings.amount;
                vertex.moved = true;
            }
        });
    }
    const auto end_all = [&] {
        for (std::size_t v = 0; v < from.size(); ++v) {
            out.vertices[v].position = from[v];
            out.vertices[v].held = held[v] != 0;
            out.vertices[v].displacement = 0;
            if (out.vertices[v].moved)
                end_at(from[v], mesh.position[v], settings.most, out.vertices[v]);
            mesh.position[v] = out.vertices[v].position;
        }
    };
    end_all();  // no farther than they may
    out.turned = hold_back_turned(mesh, around, toward, from, mesh.position);
    for (const std::uint32_t v : out.turned.kept)
        out.vertices[v].moved = false, out.vertices[v].held_back = true;
    if (out.turned.n_held_back > 0) end_all();
    return out;
}

}  // namespace slim
