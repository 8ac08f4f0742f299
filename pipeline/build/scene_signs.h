#pragma once

#include "pipeline/build/normals_stage.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/stage.h"
#include "slim/base/vec.h"
#include "slim/model/point_block.h"
#include "slim/normals/orient.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace slim {

/// WORK/signs.slice: the sample of SceneSigns.
std::filesystem::path scene_signs_path(const std::filesystem::path& work);

/// Which side of each part of a cloud is out, where a job of several slices estimates all normals:
/// a sample of the whole is oriented at once, as a job of one slice would be. A slice sees pieces
/// of parts only (slim/normals/notes/0007).
struct SceneSigns {
    std::vector<std::uint64_t> id;  ///< rising
    std::vector<Vec3f> normal;
    bool is_flat = false;  ///< as OrientReport says

    /// The normals of those of the sample that are among the points.
    std::vector<SampledNormal> of(const PointBlock& points) const;

private:
    friend SceneSigns scene_signs(const NormalsConfig&, const SlicePlan&,
                                  const std::vector<Vec3d>&, const StageContext&);
    double share_ = 0;
};

/// Makes the sample, or reads the file of one that is up to date. Up to 200,000 points. Reads all
/// slices once; memory: as a slice of so many points.
SceneSigns scene_signs(const NormalsConfig& config, const SlicePlan& plan,
                       const std::vector<Vec3d>& sensors, const StageContext& context);

}  // namespace slim
