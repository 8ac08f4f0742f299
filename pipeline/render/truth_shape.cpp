#include "pipeline/render/truth_shape.h"

#include "pipeline/box_text.h"
#include "pipeline/shape_name.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace slim {

void check_truth(const RenderConfig& config) {
    if (!config.truth_shape.empty()) shape_named(config.truth_shape, "truth_shape");
    shape_offset(config.offset);
}

void refuse_far_truth(const RenderConfig& config, const Bbox& drawn) {
    const Shape& shape = find_shape(config.truth_shape);
    const Vec3d offset = shape_offset(config.offset);
    Vec3d gap;
    for (std::size_t axis = 0; axis < 3; ++axis)
        gap[axis] = std::max({0.0, drawn.lo[axis] - offset[axis] - shape.bounds.hi[axis],
                              shape.bounds.lo[axis] - (drawn.hi[axis] - offset[axis])});
    if (length(gap) <= kFarOffShape * shape.bounds.diagonal()) return;
    throw NumericalError(fmt::format(
        "{}: lies farther than ten of its diagonals from the shape {} ({} to {}, the shape about "
        "{}): is the model in the shape's frame and unit? --offset says where in the world the "
        "shape lies. Nothing is drawn",
        config.model, config.truth_shape, point_text(drawn.lo), point_text(drawn.hi),
        point_text(offset)));
}

}  // namespace slim
