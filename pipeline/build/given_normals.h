#pragma once

#include "pipeline/build/slice_normals.h"

#include <cstddef>
#include <string>
#include <vector>

namespace slim {

/// Neighbours that normals are estimated from where noise does not ask for more.
inline constexpr std::size_t kUsualNeighbors = 16;

/// Why given normals are not to be trusted; empty if they are.
struct Mistrust {
    std::string why;
    bool they_hint = false;  ///< which side is out, most of them
};

/// Mends given normals of scans turned round, in patches and here and there, and looks at them as a
/// whole (slim/normals/notes). Warns of what it turns.
/// n_own     points of the slice's own that have a normal
/// is_whole  the job has one slice: scans and patches are turned, as it is known which side has
///           fewer points; else patches are told of and scans not looked at
Mistrust audit_given(PointBlock& points, const NearestSearch& search, const std::vector<bool>& own,
                     std::size_t n_own, const std::vector<Vec3d>& sensors, bool is_whole,
                     NormalsReport& report, Reporter& reporter);

}  // namespace slim
