#pragma once

#include "pipeline/config.h"
#include "slim/base/error.h"
#include "slim/shapes/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace slim {

/// The analytic shape that an option or word of this key names. ConfigError with the nearest name.
inline const Shape& shape_named(const std::string& name, const std::string& key) {
    const std::vector<std::string> known = shape_names();
    if (std::find(known.begin(), known.end(), name) == known.end())
        throw ConfigError({.key = key,
                           .expected = fmt::format("one of {}", fmt::join(known, ", ")),
                           .found = "'" + name + "'",
                           .hint = did_you_mean(name, known)});
    return find_shape(name);
}

/// Where an option `offset` says that a shape's origin lies in the world. ConfigError unless it is
/// three numbers, or none.
inline Vec3d shape_offset(const std::vector<double>& offset) {
    if (offset.empty()) return {};
    if (offset.size() != 3)
        throw ConfigError({.key = "offset",
                           .expected = "three numbers x,y,z",
                           .found = std::to_string(offset.size())});
    return {offset[0], offset[1], offset[2]};
}

/// Of a shape's diagonal: what lies so far from its bounds is of another frame.
inline constexpr double kFarOffShape = 10;

}  // namespace slim
