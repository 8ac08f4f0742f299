#pragma once

#include "slim/cover/cover_counts.h"

#include <nlohmann/json.hpp>

namespace slim {

nlohmann::json counts_json(const CoverCounts& counts);

/// Adds the counts of one fit to those of a job: sums, of levels the most.
void add_counts(const nlohmann::json& one, nlohmann::json& sum);

}  // namespace slim
