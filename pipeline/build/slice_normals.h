#pragma once

#include "pipeline/build/normals_stage.h"
#include "slim/base/reporter.h"
#include "slim/base/vec.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/nearest.h"
#include "slim/normals/evidence.h"
#include "slim/normals/orient.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace slim {

/// Counts of one slice, by what became of the normals.
struct NormalsReport {
    std::size_t neighbors = 0;  ///< that each was estimated from
    std::size_t kept = 0, turned = 0,
                estimated = 0;  ///< what became of the cloud's own, and how many had none
    std::size_t estimates_turned = 0;                 ///< as their neighbours opposed them
    std::size_t estimates_widened = 0;  ///< from more neighbours: noise is as thick as those reach
    std::size_t of_contrary_scans = 0;  ///< of scans that were turned whole, before all else
    /// of patches that oppose those about them; turned in a job of one slice
    std::size_t of_contrary_patches = 0;
    std::size_t degenerate = 0;                       ///< estimates from neighbours on a line
    std::size_t on_lines = 0;                         ///< of lines whose next ones are far
    std::size_t noisy = 0;  ///< of all: far off their neighbours', but not opposed
    OrientReport orientation;
    NormalEvidence evidence;  ///< of given normals that are kept
};

/// About that share of a slice's own points, by rising hash of their id.
std::vector<std::uint32_t> sample_points(const PointBlock& points, const std::vector<bool>& own,
                                         double share);

/// Estimates and orients the normals of a sample of a whole cloud (local frame, Morton order),
/// which has none, as give_normals does where all are estimated; not flipped.
OrientReport orient_sample(PointBlock& points, const NormalsConfig& config,
                           const std::vector<Vec3d>& sensors);

/// Normals of a slice's points (local frame, Morton order, `search` over them): given ones kept,
/// turned where they oppose their neighbours, estimated where they are missing or not to be
/// trusted, flipped at last, as config.normals says. whole: of a slice of several, for which side
/// is out; seen_from_above: what the slices before found. own: which points are the slice's own;
/// the report is of those. Warns through the reporter of many wrong ones.
NormalsReport give_normals(PointBlock& points, const NearestSearch& search,
                           const std::vector<bool>& own,
                           const std::optional<WholeScene>& whole,
                           const NormalsConfig& config, const SlicePlan& plan,
                           const std::vector<Vec3d>& sensors, bool seen_from_above,
                           Reporter& reporter);

}  // namespace slim
