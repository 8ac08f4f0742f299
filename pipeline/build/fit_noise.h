#pragma once

#include "pipeline/build/plan_file.h"

#include <string>

namespace slim {

/// What all slices share: lambda, spacing and the noise of the normals, from the normals stage's
/// manifests.
struct GlobalNoise {
    /// lambda: no less than (4 q)^2, q the step between floats, than smoothed_variance(), and than
    /// what the coordinates' own steps make
    double noise_variance = 0;
    double step_variance = 0;   ///< the least error squared of a ball, of coordinates in steps;
                                ///< 0: none, or lambda is as configured
    double mean_variance = 0;   ///< lambda with all strays and noisy parts
    double stray_density = 0;   ///< strays to the volume of the cloud's box; 0 if they hardly count
    bool are_estimated = false;   ///< most of the normals are
    double contrary_share = 0;  ///< of normals that noise turns out of a height field
    double typical_variance = 0;  ///< noise of a typical place, without what edges add to lambda
    double spacing = 0;         ///< square root of the area that a point usually has
    bool lines_are_wires = false;  ///< there are some, and most of the cloud is dense both ways
    bool floored = false;
    /// the cloud's own normals tell more of its shape than its positions
    bool normals_inform = false;
};
/// lambda: as configured, 0: as measured
/// throws  IncompleteError (exit 6) naming the slices whose normals are missing, or were
///         made with different options
GlobalNoise read_global_noise(const std::string& work, double lambda, const SlicePlan& plan);

}  // namespace slim
