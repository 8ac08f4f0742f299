#pragma once

#include "pipeline/build/normals_stage.h"
#include "pipeline/build/plan_file.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/box_tree.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

namespace slim {

// Points of other slices near a slice's region, its rim: neighbours for those at the cut, and where
// all normals are estimated the signs of the slices before.

/// Whether all normals of the job are estimated: then signs are carried from slice to slice.
bool signs_carry_over(const NormalsConfig& config, const SlicePlan& plan);

/// The file of another slice's part of the rim: one before carries signs where all are estimated.
/// throws IncompleteError if it has no normals yet
std::filesystem::path rim_of(const NormalsConfig& config, const SlicePlan& plan, std::size_t other,
                             std::size_t slice);

/// The slices that the rim is of: those near this one; where signs carry over, the one before in
/// any case, so that all before have theirs.
std::vector<std::size_t> rims(const NormalsConfig& config, const SlicePlan& plan,
                              std::size_t slice);

/// Whether the slice before took the cloud for an airborne scan.
/// throws FormatError if its manifest does not say
bool was_from_above(const NormalsConfig& config, const SlicePlan& plan, std::size_t slice);

/// A slice's points (`handed`, if given) and those of others near it, whose normals are zero where
/// all are estimated but for those of slices before.
PointBlock read_with_rims(const NormalsConfig& config, const SlicePlan& plan, std::size_t slice,
                          std::optional<PointBlock> handed);

/// Which of the points are the slice's own. boxes: over the points, in their order
std::vector<bool> own_points(const SlicePlan& plan, std::size_t slice, const PointBlock& points,
                             const BoxTree& boxes);

}  // namespace slim
