#pragma once

#include "slim/base/vec.h"

namespace slim {

/// Coordinates of a scene in floats: relative to its middle and over half its diagonal, so that
/// everything is of the order of 1 whatever a model's units are.
struct SceneFrame {
    Vec3d middle;
    double unit = 1;  ///< model units

    Vec3f from_job(const Vec3d& p) const { return to_float((p - middle) / unit); }
    Vec3d to_job(const Vec3d& p) const { return middle + p * unit; }
};

}  // namespace slim
