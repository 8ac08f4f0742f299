#pragma once

#include "pipeline/config.h"
#include "slim/base/error.h"
#include "slim/shapes/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace slim {

/// The analytic shape that an option or word names. ConfigError beginning with `where`,
/// with the nearest name.
inline const Shape& shape_named(const std::string& name, const std::string& where) {
    const std::vector<std::string> known = shape_names();
    if (std::find(known.begin(), known.end(), name) == known.end())
        throw ConfigError(fmt::format("{}: expected one of {}; found \"{}\"{}", where,
                                      fmt::join(known, ", "), name, suggestion(name, known)));
    return find_shape(name);
}

}  // namespace slim
