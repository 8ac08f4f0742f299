#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace slim {

/// Squared distances of places to the nearest point of a cloud that is read once.
class NearestPoints {
public:
    /// `places`, finite, must outlive this; 8 bytes a place.
    explicit NearestPoints(const std::vector<Vec3d>& places);
    /// The next points, all finite, in the places' frame. Cost: 2 us a place that may be near to them, 32 bytes a point
    /// while it runs; in parallel, the same for any thread count.
    void add(const std::vector<Vec3d>& points);
    /// Infinite without any point.
    const std::vector<double>& squares() const { return sq_; }

private:
    const std::vector<Vec3d>& places_;
    std::vector<double> sq_;
    std::vector<std::size_t> near_;
    std::vector<Vec3d> queries_;
    std::vector<std::uint32_t> indices_;
    std::vector<double> found_;
};

/// Squared distance of each place to the nearest finite point of a cloud, in chunks of a million points that are not held.
/// origin      taken off the points: the places' frame
/// each_chunk  told how many bytes of the file's are read
/// throws      as open_cloud
std::vector<double> sq_to_points(const std::vector<Vec3d>& places, const std::string& cloud, const Vec3d& origin,
                                 const std::function<void(std::uint64_t done, std::uint64_t total)>& each_chunk);

}  // namespace slim
