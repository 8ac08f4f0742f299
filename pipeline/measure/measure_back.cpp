#include "pipeline/measure/measure_back.h"

#include "pipeline/measure/measure_cloud.h"
#include "pipeline/measure/mesh_input.h"
#include "pipeline/measure/nearest_points.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/smooth/mesh_distance.h"
#include "slim/smooth/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

constexpr std::size_t kGrain = 1024;

std::vector<Vec3d> places_of(const std::vector<SurfaceSample>& samples) {
    std::vector<Vec3d> out;
    out.reserve(samples.size());
    for (const SurfaceSample& s : samples) out.push_back(s.point);
    return out;
}

std::vector<double> to_points(const std::vector<SurfaceSample>& samples, const std::string& cloud,
                              const Vec3d& origin, StageContext& context) {
    return sq_to_points(places_of(samples), cloud, origin,
                        [&](std::uint64_t done, std::uint64_t total) {
                            context.reporter.progress("model to cloud", done, total);
                            context.check_stop();
                        });
}

std::vector<double> to_faces(const std::vector<SurfaceSample>& samples, const std::string& path,
                             const Vec3d& origin) {
    const MeshDistance mesh(read_mesh(path, origin));
    if (mesh.n_triangles() == 0)
        throw DataError(path +
                        ": two_way: no face of three or more finite corners to measure to; "
                        "expected faces, or a PLY without the element face, whose points are then "
                        "measured to");
    std::vector<double> sq(samples.size());
    parallel_blocks(sq.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) sq[i] = mesh.sq_distance(samples[i].point);
    });
    return sq;
}

}  // namespace

json measure_back(const ModelFile& model, const BallIndex& index, const std::string& cloud,
                  std::size_t n_samples, double tolerance, StageContext& context) {
    const std::vector<SurfaceSample> samples = sample_surface(model.tree(), index, n_samples);
    if (samples.empty()) throw DataError(model.path() + ": no surface to sample");
    const bool faces = is_mesh(cloud);
    const Vec3d origin = model.header().origin;
    const double diagonal = model.header().diagonal;
    const std::vector<double> sq =
        faces ? to_faces(samples, cloud, origin) : to_points(samples, cloud, origin, context);
    if (std::any_of(sq.begin(), sq.end(), [](double d) { return !std::isfinite(d); }))
        throw DataError(cloud +
                        ": two_way: its nearest face or point is farther from the model than the "
                        "squares of numbers go (1e154); expected coordinates in the model's frame");
    double area = 0, sum = 0, within = 0;
    std::size_t farthest = 0;
    LogHistogram distances;
    for (std::size_t i = 0; i < sq.size(); ++i) {
        area += samples[i].area, sum += samples[i].area * sq[i];
        const double distance = std::sqrt(sq[i]);
        within += distance <= tolerance * diagonal ? samples[i].area : 0;
        distances.add(distance);
        if (sq[i] > sq[farthest]) farthest = i;
    }
    const Vec3d at = samples[farthest].point + origin;
    json out = {{"to", faces ? "faces" : "points"},
                {"samples", samples.size()},
                {"area", area},
                {"l2", rms(sum, area, diagonal)},
                {"max", std::sqrt(sq[farthest]) / diagonal},
                {"max_at", {at.x, at.y, at.z}},
                {"within", within / area}};
    if (!faces)
        out["note"] = "to the nearest point: not below about half the spacing of the points";
    put_percentiles(distances, diagonal, out);
    return out;
}

}  // namespace slim
