#pragma once

#include "raytrace/lines/feature_line.h"
#include "slim/base/vec.h"

#include <span>
#include <string>

namespace slim {

/// The lines in space as a binary PLY (CONVENTIONS 1.5): element vertex with float x y z, local to
/// the `origin` that a comment names, float scalar_strength and quality (both its line's strength)
/// and uchar type (LineKind, named in comments); element edge with int vertex1 vertex2.
std::string lines_ply(std::span<const FeatureLine> lines, const Vec3d& origin);

/// The same as a Wavefront OBJ: one object per kind, one `l` element per line, its strength in a
/// comment.
std::string lines_obj(std::span<const FeatureLine> lines, const Vec3d& origin);

}  // namespace slim
