#pragma once

#include "slim/base/bbox.h"
#include "slim/model/surfel.h"

#include <vector>

namespace slim {

/// Those of some leaves whose balls meet a box, in their order. Cost: O(leaves).
inline std::vector<const Surfel*> leaves_meeting(const Bbox& box,
                                                 const std::vector<const Surfel*>& leaves) {
    std::vector<const Surfel*> out;
    for (const Surfel* s : leaves)
        if (box.sq_distance(s->center) < s->support_radius * s->support_radius) out.push_back(s);
    return out;
}

}  // namespace slim
