#pragma once

#include "formats/point_source.h"
#include "pipeline/build/cloud_spread.h"
#include "pipeline/build/gathered_points.h"
#include "pipeline/build/plan_file.h"
#include "slim/base/bbox.h"
#include "slim/base/reporter.h"
#include "slim/slicing/cell_counts.h"
#include "slim/slicing/far_strays.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// What one pass over all clouds of a job finds out.
struct CloudSurvey {
    std::vector<PlanInput> inputs;
    std::vector<std::string> hashes;  ///< of the inputs' files, as hash_file() has them
    std::vector<Bbox> boxes;    ///< of the finite points of each input, world frame
    Bbox bounds;                ///< world frame, finite points
    FarStrays::Found strays;    ///< of all inputs together
    std::uint64_t n_points = 0; ///< finite
    std::uint64_t n_dropped = 0;
    std::optional<CellCounts> cells;  ///< world frame; of points not gathered
    GatheredPoints gathered{0};  ///< all, or none if they are too many
    bool is_float32 = false;
    double coordinate_quantum = 0;  ///< largest of the inputs', of points that are no strays
    CloudSpread spread;
    bool some_have_breadth = false;  ///< an input whose first points are of no line by themselves
};

/// Reads all clouds once. Up to most_gathered points are kept; cells are counted of more. strict: a
/// point without finite coordinates is a DataError naming it. face_points: as open_cloud has it.
/// throws what open_cloud() and read() throw; DataError if scan numbers do not fit 16 bits together
/// cost   two chunks of points in memory, and 46 bytes a gathered point
CloudSurvey survey_clouds(const std::vector<std::string>& paths, bool strict,
                          std::uint64_t most_gathered, Reporter& reporter,
                          bool face_points = false);

/// Step between floats at the magnitude of the coordinates as stored, 1 for integers, else 0.
double coordinate_quantum(const CloudInfo& info, const Bbox& world_bounds);

}  // namespace slim
