#pragma once

#include "slim/base/vec.h"
#include "slim/model/surfel.h"

#include <optional>
#include <span>

namespace slim {

/// Unit normals of the sheets about a point that brings none.
struct SheetNormals {
    Vec3d first;   ///< normal_at(); where there is a second, of the supporters that agree with it
    Vec3d second;  ///< of those that face away from the first: the other side of a thin plate. Zero
                   ///< without such
};

/// Nothing if p has no supporter.
std::optional<SheetNormals> sheet_normals_at(const Vec3d& p,
                                             std::span<const Surfel* const> supporters);

}  // namespace slim
