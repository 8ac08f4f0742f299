#pragma once

#include "formats/cloud_rewriter.h"
#include "pipeline/smooth/smooth_stage.h"
#include "slim/base/bbox.h"
#include "slim/smooth/feature_edges.h"
#include "slim/smooth/smoothing.h"

#include <nlohmann/json.hpp>

#include <cstdint>

namespace slim {

/// What is counted over the points, in file order.
struct SmoothCounts {
    std::uint64_t points = 0, moved = 0, unsupported = 0, held = 0, opposed = 0, astray = 0,
                  not_finite = 0;
    std::uint64_t by_model = 0, held_back = 0, kept = 0;
    double sq_displacement = 0, max = 0;
    Bbox box;  // of the finite points as they were, frame of the job

    void add(const Vec3d& from, const SmoothedPoint& p);
    /// The keys that clouds and meshes share.
    nlohmann::json to_json(const char* mode) const;
};

/// A model opened for smoothing, and how.
struct Smoother {
    const SmoothConfig& config;
    StageContext& context;
    const SurfelTree& tree;
    const BallIndex& index;
    Vec3d origin;
    double diagonal;
    bool sharp;              // built with --sharp on
    SmoothModelRules rules;  // of a build without

    /// What coordinates in text are rounded to: a hundredth of a float's step.
    double text_step() const { return 1e-9 * diagonal; }
    /// Of the points that the model was built of, which the rewritten ones are to say.
    double noise_variance() const { return config.amount > 0 ? rules.noise_variance : 0; }
    SmoothSettings settings() const { return {config.iterations, config.amount, config.most}; }
    /// World position; a point that stays keeps the bytes of its coordinates.
    RewrittenPoint rewritten(const SmoothedPoint& p) const {
        return {p.position + origin, to_float(p.normal), static_cast<float>(p.displacement),
                p.moved};
    }
};

/// Nothing is written where the model says nothing of any point.
/// throws  DataError: no finite point; NumericalError: none was moved and some are unsupported
void require_moved(const Smoother& smoother, const SmoothCounts& counts);

}  // namespace slim
