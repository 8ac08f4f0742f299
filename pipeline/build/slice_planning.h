#pragma once

#include "pipeline/build/cloud_survey.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/build/slice_stage.h"
#include "slim/slicing/block_plan.h"

namespace slim {

/// The slices of the clouds that were surveyed: as many as were asked for, or as leave room for the
/// halo that the fit wants. `blocks`, in the world's frame, are what they are cut by; none of
/// points that were gathered, which are one slice.
SlicePlan plan_from_survey(const SliceConfig& config, const CloudSurvey& survey, BlockPlan& blocks);

}  // namespace slim
