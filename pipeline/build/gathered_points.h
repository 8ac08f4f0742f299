#pragma once

#include "formats/point_source.h"
#include "slim/base/bbox.h"
#include "slim/model/point_block.h"

#include <cstdint>

namespace slim {

/// All finite points of a job, kept while it is read as long as they are few: a job of one slice
/// need not be read twice. World frame: `points.origin` is zero.
class GatheredPoints {
public:
    /// most_points: beyond these nothing is kept.
    explicit GatheredPoints(std::uint64_t most_points) : most_points_(most_points) {}

    /// Takes a chunk of the input whose scans begin at first_scan. False if they are too many now;
    /// then release() what came before.
    bool add(const PointChunk& chunk, std::uint64_t first_id, std::uint32_t first_scan,
             const CloudInfo& info);
    const PointBlock& points() const { return points_; }
    /// Gives the points away, with the columns that a plan says; no more are kept.
    PointBlock release(bool has_normals, bool has_scans);

private:
    void reserve(const CloudInfo& info);

    PointBlock points_;
    std::uint64_t most_points_;
};

}  // namespace slim
