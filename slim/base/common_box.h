#pragma once

#include "slim/base/bbox.h"

#include <algorithm>
#include <cstddef>

namespace slim {

/// What both boxes hold; empty() where that is nothing.
inline Bbox common(const Bbox& a, const Bbox& b) {
    Bbox out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        out.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
        out.hi[axis] = std::min(a.hi[axis], b.hi[axis]);
        if (!(out.lo[axis] <= out.hi[axis])) return {};
    }
    return out;
}

}  // namespace slim
