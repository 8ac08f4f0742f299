#pragma once

#include "slim/base/bbox.h"

#include <fmt/format.h>

#include <string>

namespace slim {

/// For messages. Nine digits: centimetres of coordinates of a whole country.
inline std::string point_text(const Vec3d& p) {
    return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x, p.y, p.z);
}

/// "(0, 0, 0) to (1, 1, 1)"
inline std::string box_text(const Bbox& box) {
    return point_text(box.lo) + " to " + point_text(box.hi);
}

}  // namespace slim
