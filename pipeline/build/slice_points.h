#pragma once

#include "pipeline/build/fit_division.h"
#include "pipeline/build/plan_file.h"
#include "slim/model/point_block.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace slim {

/// The oriented points of a slice and those of its neighbours within the halo, in the slices'
/// order. Only what is wanted of the neighbours is held.
PointBlock read_with_halo(const std::string& work, const SlicePlan& plan, std::size_t slice,
                          double halo);

/// The points in_share() of all slices.
PointBlock read_coarse_sample(const std::string& work, const SlicePlan& plan, double share,
                              std::uint64_t seed);

}  // namespace slim
