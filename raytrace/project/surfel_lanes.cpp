#include "raytrace/project/surfel_lanes.h"

#include <algorithm>

namespace slim {

SurfelLanes SurfelBatch::lanes(const PixelView& view) {
    for (auto& field : v_) std::fill(field + n_, field + kSurfelLanes, field[n_ - 1]);
    std::size_t next = 0;
    const auto get = [&] { return DoubleV(v_[next++], stdx::vector_aligned); };
    const auto get_vec = [&] {
        const DoubleV x = get(), y = get(), z = get();
        return Vec3D{x, y, z};
    };
    const auto turned = [&](const Vec3D& d) {
        const auto along = [&](const Vec3d& axis) { return axis.x * d.x + axis.y * d.y + axis.z * d.z; };
        return Vec3D{along(view.right), along(view.down), along(view.forward)};
    };
    SurfelLanes s;
    s.center = get_vec(), s.radius = get();
    s.e_u = turned(get_vec()), s.e_v = turned(get_vec()), s.e_w = turned(get_vec());
    for (DoubleV& a : s.a) a = get();
    return s;
}

}  // namespace slim
