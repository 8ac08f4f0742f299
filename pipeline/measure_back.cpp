#include "pipeline/measure_back.h"

#include "formats/cloud_kind.h"
#include "formats/point_source.h"
#include "pipeline/measure_cloud.h"
#include "pipeline/mesh_input.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/neighbors/knn.h"
#include "slim/smooth/mesh_distance.h"
#include "slim/smooth/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

constexpr std::size_t kChunk = 1 << 20;
constexpr std::size_t kGrain = 1024;

/// Squared distances of samples to a cloud that is read once.
class NearestPoints {
public:
    explicit NearestPoints(const std::vector<SurfaceSample>& samples)
        : samples_(samples), sq_(samples.size(), std::numeric_limits<double>::infinity()) {}

    /// Takes the next points, frame of the job.
    void add(const std::vector<Vec3d>& points) {
        if (points.empty()) return;
        Bbox box;
        for (const Vec3d& p : points) box.extend(p);
        near_.clear(), queries_.clear();
        for (std::size_t i = 0; i < samples_.size(); ++i)
            if (box.sq_distance(samples_[i].point) < sq_[i]) {
                near_.push_back(i);
                queries_.push_back(samples_[i].point);
            }
        if (near_.empty()) return;
        KnnIndex(points).search(queries_, 1, indices_, found_);
        for (std::size_t k = 0; k < near_.size(); ++k)
            sq_[near_[k]] = std::min(sq_[near_[k]], found_[k]);
    }
    const std::vector<double>& squares() const { return sq_; }

private:
    const std::vector<SurfaceSample>& samples_;
    std::vector<double> sq_;
    std::vector<std::size_t> near_;
    std::vector<Vec3d> queries_;
    std::vector<std::uint32_t> indices_;
    std::vector<double> found_;
};

std::vector<double> to_points(const std::vector<SurfaceSample>& samples, const std::string& cloud,
                              const Vec3d& origin, StageContext& context) {
    NearestPoints nearest(samples);
    const auto source = open_cloud(cloud);
    PointChunk chunk;
    std::vector<Vec3d> points;
    while (source->read(chunk, kChunk)) {
        points.clear();
        for (const Vec3d& p : chunk.position)
            if (is_finite(p)) points.push_back(p - origin);
        nearest.add(points);
        context.reporter.progress("model to cloud", source->bytes_read(),
                                  source->info().file_size);
        context.check_stop();
    }
    return nearest.squares();
}

std::vector<double> to_faces(const std::vector<SurfaceSample>& samples, const std::string& path,
                             const Vec3d& origin) {
    const MeshDistance mesh(read_mesh(path, origin));
    if (mesh.n_triangles() == 0)
        throw DataError(path + ": two_way: no face of three or more finite corners to measure to; expected faces, or a "
                               "PLY without the element face, whose points are then measured to");
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
        throw DataError(cloud + ": two_way: its nearest face or point is farther from the model than the squares of numbers go "
                                "(1e154); expected coordinates in the model's frame");
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
