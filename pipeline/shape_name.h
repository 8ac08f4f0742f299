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

}  // namespace slim
