#pragma once

#include "pipeline/measure/measure_cloud.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// How two clouds are compared.
struct ComparedClouds {
    std::string first, second;
    std::string per_point;   ///< PLY to write; empty: none
    double tolerance = 0;    ///< over the first's diagonal
    bool two_way = false;
};

/// Compares two clouds point by point, the n-th with the n-th: what became of a cloud whose order
/// was kept. With `two_way` also by nearest points, both ways, which no order and no number matters
/// to: then alone if they are not as many.
///
/// per_point  a PLY of the second's points: scalar_distance (and quality) to the first's (model
///            units), scalar_normal_angle where both have normals (degrees)
/// returns  points (compared), not_finite (in either), l2 (RMS displacement), max, max_at (of the
///          first, world), p50 p90 p95 p99, within (share of the points that went no farther than
///          `tolerance`), diagonal (L, of the first), distances over L; normal_mean_deg,
///          normal_rms_deg where both have normals; first_to_second, second_to_first: the same of
///          the distances to the nearest point (points, not_finite, l2, max, max_at, p50 ...,
///          within)
/// throws   DataError where they are not as many (without two_way, or with per_point), without a
///          finite point in either, or (without two_way) none that is finite in both, or so far
///          apart that squares overflow; as open_cloud and AtomicFile
/// cost     point by point: two chunks in memory. two_way: 32 bytes a point of one cloud, and what
///          a chunk of the other takes (sq_to_points; 3 million points beside 1,000: 114 MiB); time
///          by 2 us a point and chunk of the other
nlohmann::json compare_clouds(const ComparedClouds& clouds, StageContext& context);

}  // namespace slim
