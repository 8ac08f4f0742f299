#include "slim/model/distinct_points.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace slim {
namespace {

constexpr float kSameSide = 0.7071f;  // cosine of 45 degrees

/// The points of one place that are kept, as an end of the block's kept part; normals are sums
/// until it is left.
class Place {
public:
    explicit Place(PointBlock& points) : points_(points) {}

    /// Moves point i to the kept ones, or adds its normal to one of its place;
    /// false if it was a copy.
    bool take(std::size_t i) {
        if (begin_ == end_ || points_.position[i] != points_.position[begin_]) leave();
        if (!points_.has_normals()) {
            if (begin_ < end_) return false;
            keep(i);
            return true;
        }
        const Vec3f normal = points_.normal[i];
        for (std::size_t k = begin_; k < end_; ++k) {
            Vec3f& sum = points_.normal[k];
            const float cosine = dot(sum, normal), sizes = length(sum) * length(normal);
            if (sizes > 0 && !(cosine > kSameSide * sizes)) continue;
            if (sizes > 0 || length(sum) == 0) sum = sum + normal;
            ++copies_;
            return false;
        }
        keep(i);
        return true;
    }
    /// Normals of the place become unit again, those without copies stay as they were.
    void leave() {
        if (copies_ > 0 && points_.has_normals())
            for (std::size_t k = begin_; k < end_; ++k)
                if (const float size = length(points_.normal[k]); size > 0)
                    points_.normal[k] = points_.normal[k] / size;
        begin_ = end_;
        copies_ = 0;
    }
    std::size_t n_kept() const { return end_; }

private:
    void keep(std::size_t i) {
        if (i != end_) {
            points_.position[end_] = points_.position[i];
            points_.id[end_] = points_.id[i];
            if (points_.has_normals()) points_.normal[end_] = points_.normal[i];
            if (points_.has_scans()) points_.scan[end_] = points_.scan[i];
        }
        ++end_;
    }

    PointBlock& points_;
    std::size_t begin_ = 0, end_ = 0;  // the place's among the kept
    std::size_t copies_ = 0;
};

/// Whether any point lies where the one before it does.
bool has_copies(const PointBlock& points) {
    std::atomic<bool> any = false;
    parallel_blocks(points.size(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = std::max<std::size_t>(begin, 1); i < end; ++i)
            if (points.position[i] == points.position[i - 1]) {
                any = true;
                return;
            }
    });
    return any;
}

}  // namespace

std::uint64_t keep_distinct(PointBlock& points,
                            const std::function<bool(const Vec3d&)>& is_counted) {
    if (!has_copies(points)) return 0;
    std::uint64_t copies = 0;
    Place place(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d at = points.position[i];
        if (!place.take(i) && is_counted(at)) ++copies;
    }
    place.leave();
    const std::size_t n = place.n_kept();
    points.position.resize(n);
    points.id.resize(n);
    if (points.has_normals()) points.normal.resize(n);
    if (points.has_scans()) points.scan.resize(n);
    return copies;
}

}  // namespace slim
