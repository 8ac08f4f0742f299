#pragma once

#include "pipeline/stage.h"
#include "slim/base/vec.h"
#include "slim/smooth/local_noise.h"
#include "slim/smooth/refit.h"
#include "slim/tree/ball_index.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace slim {

/// A cloud that is smoothed, and the model.
struct SmoothInput {
    const std::string& cloud;
    const std::string& memory;  ///< as the option has it
    const SurfelTree& tree;
    const BallIndex& index;
    Vec3d origin;     ///< world minus frame of the job
    double diagonal;  ///< of the model
};

/// What a cloud's points are put on beside the model, and how much of it.
struct SmoothRefit {
    std::unique_ptr<RefittedSurface> surface;                 ///< null: there is no memory for it
    std::vector<LeafTrust> trust;                             ///< empty: no point could be read
    std::size_t refitted = 0, kept = 0, kept_for_memory = 0;  ///< leaves
    std::size_t stray = 0;  ///< leaves that follow points which noise
                            ///< about others explains: left out
    double share = 1;  ///< of the cloud's points that the others were fitted to
    std::size_t batch = 0;  ///< points that memory holds once the others are no longer needed
    double noise = 0;  ///< the median of the leaves whose noise is known, over L
    /// Leaves whose points the cloud holds, by whether their noise is known.
    std::size_t known = 0, unknown = 0;

    /// Keys leaves_refitted leaves_kept leaves_kept_for_memory leaves_stray refit_share noise
    /// (null: not known of any leaf) leaves_noise_unknown.
    nlohmann::json counts() const;
};

/// Reads the cloud, as much as `memory` holds, and fits the model's surface anew to it. Warns of
/// what memory did not hold. Cost: as RefitBudget says.
SmoothRefit refit_cloud(const SmoothInput& input, StageContext& context);

/// Says what smoothing knew of the points' noise where that is not much, and where most points were
/// held back: by the counts of the result. diagonal: L.
void say_what_is_known(const nlohmann::json& result, double diagonal, const std::string& model,
                       const std::string& cloud, Reporter& reporter);

}  // namespace slim
