#include "pipeline/measure/nearest_points.h"

#include "formats/point_source.h"
#include "slim/base/bbox.h"
#include "slim/neighbors/knn.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kChunk = 1 << 20;
constexpr std::size_t kQueries = 1 << 17;  // that are searched for at a time: 6 MB

/// Squared distances of places to the nearest of points that come in parts.
class NearestPoints {
public:
    explicit NearestPoints(const std::vector<Vec3d>& places)
        : places_(places), sq_(places.size(), std::numeric_limits<double>::infinity()) {}

    /// The next points, all finite, in the places' frame.
    void add(const std::vector<Vec3d>& points) {
        if (points.empty()) return;
        Bbox box;
        for (const Vec3d& p : points) box.extend(p);
        std::optional<KnnIndex> index;
        for (std::size_t i = 0; i < places_.size();) {
            near_.clear(), queries_.clear();
            for (; i < places_.size() && near_.size() < kQueries; ++i)
                if (box.sq_distance(places_[i]) < sq_[i])
                    near_.push_back(i), queries_.push_back(places_[i]);
            if (near_.empty()) break;
            if (!index) index.emplace(points);
            index->search(queries_, 1, indices_, found_);
            for (std::size_t k = 0; k < near_.size(); ++k)
                sq_[near_[k]] = std::min(sq_[near_[k]], found_[k]);
        }
    }
    std::vector<double> take() { return std::move(sq_); }

private:
    const std::vector<Vec3d>& places_;
    std::vector<double> sq_;
    std::vector<std::size_t> near_;
    std::vector<Vec3d> queries_;
    std::vector<std::uint32_t> indices_;
    std::vector<double> found_;
};

}  // namespace

std::vector<double> sq_to_points(
    const std::vector<Vec3d>& places, const std::string& cloud, const Vec3d& origin,
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
    return nearest.take();
}

}  // namespace slim
