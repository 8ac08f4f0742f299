#pragma once

#include "slim/base/vec.h"
#include "slim/model/point_block.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// A cloud's finite points, frame of the model, or a random share of them (in_share).
struct CloudSample {
    PointBlock points;
    double share = 1;
};

/// Takes a cloud in chunks, in file order, and keeps a share of at most `most` points: all, a half,
/// a quarter, ... Which depends on the seed and on where they are in the file. 44 bytes for each of
/// `most`, touched as they come.
class CloudSampler {
public:
    CloudSampler(std::size_t most, std::uint64_t seed);

    /// positions  world frame; those that are not finite are left out, but counted for the ids
    /// normals    of each, or empty; any length, zero or not finite: none
    void add(std::span<const Vec3d> positions, std::span<const Vec3f> normals, const Vec3d& origin);
    CloudSample take();

private:
    void thin();

    std::size_t most_;
    std::uint64_t seed_, next_id_ = 0;
    CloudSample sample_;
};

}  // namespace slim
