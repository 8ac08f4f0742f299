#pragma once

#include "pipeline/build/fit_noise.h"
#include "pipeline/build/fit_options.h"
#include "pipeline/build/plan_file.h"
#include "slim/cover/level_cover.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>

namespace slim {

/// How the points of a job are covered: what the options, the plan and the noise of all slices say.
CoverRules fit_rules(const FitOptions& options, std::uint64_t seed, const SlicePlan& plan,
                     const GlobalNoise& noise);

/// Whether --sharp auto needs no look at the points: those of a mesh of large faces have its edges
/// between them, whatever its thickness (slim/fit/notes/0015).
bool is_sharp_by_faces(const FitOptions& options, const SlicePlan& plan);

/// What a tree needs to know of a fit, and what all fits of a job must share.
nlohmann::json rules_json(const CoverRules& rules);

/// What a fit takes from the normals of all slices, for its manifest.
std::string shared_values(const CoverRules& rules);

}  // namespace slim
