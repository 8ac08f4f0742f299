#include "pipeline/nearest_points.h"

#include "formats/point_source.h"
#include "slim/base/bbox.h"
#include "slim/neighbors/knn.h"

#include <algorithm>
#include <limits>

namespace slim {
namespace {

constexpr std::size_t kChunk = 1 << 20;

}  // namespace

NearestPoints::NearestPoints(const std::vector<Vec3d>& places)
    : places_(places), sq_(places.size(), std::numeric_limits<double>::infinity()) {}

void NearestPoints::add(const std::vector<Vec3d>& points) {
    if (points.empty()) return;
    Bbox box;
    for (const Vec3d& p : points) box.extend(p);
    near_.clear(), queries_.clear();
    for (std::size_t i = 0; i < places_.size(); ++i)
        if (box.sq_distance(places_[i]) < sq_[i]) {
            near_.push_back(i);
            queries_.push_back(places_[i]);
        }
    if (near_.empty()) return;
    KnnIndex(points).search(queries_, 1, indices_, found_);
    for (std::size_t k = 0; k < near_.size(); ++k) sq_[near_[k]] = std::min(sq_[near_[k]], found_[k]);
}

std::vector<double> sq_to_points(const std::vector<Vec3d>& places, const std::string& cloud, const Vec3d& origin,
                                 const std::function<void(std::uint64_t done, std::uint64_t total)>& each_chunk) {
    NearestPoints nearest(places);
    const auto source = open_cloud(cloud);
    std::vector<Vec3d> points;
    for (PointChunk chunk; source->read(chunk, kChunk);) {
        points.clear();
        for (const Vec3d& p : chunk.position)
            if (is_finite(p)) points.push_back(p - origin);
        nearest.add(points);
        each_chunk(source->bytes_read(), source->info().file_size);
    }
    return nearest.squares();
}

}  // namespace slim
