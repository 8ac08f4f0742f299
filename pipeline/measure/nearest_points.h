#pragma once

#include "slim/base/vec.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace slim {

/// Squared distance of each place to the nearest finite point of a cloud, in chunks of a million
/// points that are not held.
/// origin      taken off the points: the places' frame
/// each_chunk  told how many bytes of the file's are read
/// returns     infinite where the cloud has no point
/// throws      as open_cloud
/// cost        8 bytes a place; about 95 MiB for a chunk of a million points and its tree, less for
///             fewer; 2 us a place and chunk that may be near to it; in parallel,
///             the same for any thread count
std::vector<double> sq_to_points(
    const std::vector<Vec3d>& places, const std::string& cloud, const Vec3d& origin,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& each_chunk);

}  // namespace slim
