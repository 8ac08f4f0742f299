#pragma once

#include "pipeline/build/plan_file.h"
#include "slim/base/vec.h"

#include <string>
#include <vector>

namespace slim {

/// Where the scanner of a cloud's scans.json would lie: cloud.ply -> cloud.scans.json.
std::string scans_json_path(const std::string& cloud_path);

/// Sensor positions by scan number, local frame of the plan, NaN where unknown: from `sensors_file`
/// (of the first input) or, if empty, from the scans.json beside each input. Empty if there is
/// none.
/// throws IoError, FormatError
std::vector<Vec3d> read_sensors(const std::string& sensors_file, const SlicePlan& plan);

/// Of the positions alone, whatever their file is called; empty without any.
std::string sensors_hash(const std::vector<Vec3d>& sensors);

}  // namespace slim
