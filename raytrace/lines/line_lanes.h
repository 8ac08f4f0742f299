#pragma once

#include "raytrace/lanes_of_vec.h"
#include "raytrace/lines/line_scene.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace slim {

/// Entries i, i + 1, ... of a plane; zeros beyond its end.
[[gnu::always_inline]] inline FloatV lanes_at(const std::vector<float>& plane, std::size_t i) {
    if (i + kLanes <= plane.size()) return FloatV(plane.data() + i, stdx::element_aligned);
    alignas(FloatV) std::array<float, kLanes> some{};
    std::copy(plane.begin() + static_cast<std::ptrdiff_t>(std::min(i, plane.size())), plane.end(),
              some.begin());
    return FloatV(some.data(), stdx::vector_aligned);
}
[[gnu::always_inline]] inline LanesOfVec lanes_at(const std::array<std::vector<float>, 3>& planes,
                                                  std::size_t i) {
    return {lanes_at(planes[0], i), lanes_at(planes[1], i), lanes_at(planes[2], i)};
}

/// LineScene::footprint of some points.
[[gnu::always_inline]] inline FloatV footprints(const LineScene& s, const LanesOfVec& points) {
    if (s.view.orthographic) return FloatV(static_cast<float>(1 / s.view.px_per_unit));
    const FloatV depth =
        LanesOfVec(to_float(s.view.forward)).dot(points - LanesOfVec(to_float(s.view.eye)));
    return depth / static_cast<float>(s.view.focal_px);
}

}  // namespace slim
