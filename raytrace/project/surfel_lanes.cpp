#include "raytrace/project/surfel_lanes.h"

#include <algorithm>

namespace slim {
namespace {

DoubleV sign_of(const DoubleV& x) { return lanes_copysign(DoubleV(1.0), x); }

/// normal_from_octahedral.
Vec3D normals_from_octahedral(const DoubleV& s, const DoubleV& t) {
    const DoubleV size_s = stdx::abs(s), size_t = stdx::abs(t), w = 1.0 - size_s - size_t;
    const auto folded = w < 0.0;
    const Vec3D n{select<DoubleV>(folded, (1.0 - size_t) * sign_of(s), s),
                  select<DoubleV>(folded, (1.0 - size_s) * sign_of(t), t), w};
    const DoubleV len = stdx::sqrt(sq_length(n));
    return {n.x / len, n.y / len, n.z / len};
}

/// frame_from_normal.
Frame<DoubleV> frames_from_normals(const Vec3D& n) {
    const DoubleV sign = sign_of(n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    return {
        {1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

}  // namespace

[[gnu::flatten]] SurfelLanes SurfelBatch::lanes(const PixelView& view) {
    if (!full())
        for (auto& field : v_) std::fill(field + n_, field + kSurfelLanes, field[n_ - 1]);
    std::size_t next = 0;
    const auto get = [&] { return DoubleV(v_[next++], stdx::vector_aligned); };
    const auto get_vec = [&] {
        const DoubleV x = get(), y = get(), z = get();
        return Vec3D{x, y, z};
    };
    const auto turned = [&](const Vec3D& d) {
        const auto along = [&](const Vec3d& axis) {
            return axis.x * d.x + axis.y * d.y + axis.z * d.z;
        };
        return Vec3D{along(view.right), along(view.down), along(view.forward)};
    };
    SurfelLanes s;
    s.center = get_vec(), s.radius = get();
    const DoubleV normal_s = get(), normal_t = get();
    const Frame<DoubleV> frame = frames_from_normals(normals_from_octahedral(normal_s, normal_t));
    s.e_u = turned(frame.u_axis), s.e_v = turned(frame.v_axis), s.e_w = turned(frame.normal);
    for (DoubleV& a : s.a) a = get();
    return s;
}

}  // namespace slim
