#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/sharp_kernel.h"
#include "slim/model/surfel.h"

#include <cstdint>

namespace slim {

/// A surfel in the form of the general kernels, sheet by sheet; doubles inside, floats out.
SharpRecord sharp_record(const PixelView& view, const Surfel& surfel, std::uint32_t node);

}  // namespace slim
