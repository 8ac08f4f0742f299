#include "raytrace/trace/primary_rays.h"

#include <algorithm>
#include <array>

namespace slim {
namespace {

using DoubleV = stdx::native_simd<double>;
constexpr std::size_t kDoubles = std::min<std::size_t>(DoubleV::size(), kLanes);
using Doubles = stdx::simd<double, stdx::simd_abi::deduce_t<double, kDoubles>>;
using Floats = stdx::rebind_simd_t<float, Doubles>;

struct DoubleVecs {
    Doubles x, y, z;

    explicit DoubleVecs(const Vec3d& v) : x(v.x), y(v.y), z(v.z) {}
    DoubleVecs(const Doubles& a, const Doubles& b, const Doubles& c) : x(a), y(b), z(c) {}
    Doubles dot(const DoubleVecs& b) const { return x * b.x + y * b.y + z * b.z; }
    DoubleVecs operator+(const DoubleVecs& b) const { return {x + b.x, y + b.y, z + b.z}; }
    DoubleVecs operator*(const Doubles& s) const { return {x * s, y * s, z * s}; }
};

/// A packet's floats on their way from doubles, in parts.
using LaneFloats = std::array<float, kLanes>;

struct alignas(64) LanesInTwo {
    LaneFloats high, low;

    void store(std::size_t first, const Doubles& v) {
        const Floats rounded = stdx::static_simd_cast<Floats>(v);
        const Doubles rest = v - stdx::static_simd_cast<Doubles>(rounded);
        rounded.copy_to(&high[first], stdx::element_aligned);
        stdx::static_simd_cast<Floats>(rest).copy_to(&low[first], stdx::element_aligned);
    }
    FloatV load_high() const { return FloatV(high.data(), stdx::element_aligned); }
    FloatV load_low() const { return FloatV(low.data(), stdx::element_aligned); }
};
struct VecsInTwo {
    LanesInTwo x, y, z;

    void store(std::size_t first, const DoubleVecs& v) {
        x.store(first, v.x), y.store(first, v.y), z.store(first, v.z);
    }
    LanesOfVec high() const { return {x.load_high(), y.load_high(), z.load_high()}; }
    LanesOfVec low() const { return {x.load_low(), y.load_low(), z.load_low()}; }
};

/// PixelView's rays, in scene coordinates.
struct SceneRays {
    DoubleVecs origin, direction;
    Doubles t_near;

    SceneRays(const PixelView& view, const SceneFrame& frame, const Doubles& px, const Doubles& py)
        : origin(view.eye - frame.middle), direction(view.forward) {
        const DoubleVecs right(view.right), down(view.down), forward(view.forward);
        const Doubles per_px(1 / (view.orthographic ? view.px_per_unit : view.focal_px));
        const DoubleVecs across =
            right * ((px - view.center_x) * per_px) + down * ((py - view.center_y) * per_px);
        if (view.orthographic) {
            origin = origin + across;
        } else {
            direction = across + forward;
            direction = direction * (1.0 / stdx::sqrt(direction.dot(direction)));
        }
        origin = origin * Doubles(1 / frame.unit);
        t_near = Doubles(view.near_plane / frame.unit) / direction.dot(forward);
    }
};

/// From which t on a ray may meet anything; negative if nowhere.
Doubles scene_entry(const SceneRays& rays) {
    constexpr double kSqRadius = 1.0001;
    const Doubles middle = -rays.origin.dot(rays.direction);
    const DoubleVecs nearest = rays.origin + rays.direction * middle;
    const Doubles sq_half = kSqRadius - nearest.dot(nearest);
    const Doubles half = stdx::sqrt(stdx::max(sq_half, Doubles(0.0)));
    const auto meets = sq_half > 0.0 && middle + half >= rays.t_near;
    return select<Doubles>(meets, stdx::max(rays.t_near, middle - half), Doubles(-1.0));
}

/// From so far before the scene's middle on that floats are exact enough.
Doubles far_entry(const SceneRays& rays) {
    constexpr double kFarthest = 64;
    return stdx::max(-rays.origin.dot(rays.direction) - kFarthest, Doubles(0.0));
}

/// A block's rays from entry(rays) on; lanes where that is negative have none.
template <class Entry>
RayPacket rays_through(const PixelView& view, const SceneFrame& frame, const PixelBlock& block,
                       const Entry& entry) {
    VecsInTwo origin, direction;
    alignas(64) LaneFloats far;
    for (std::size_t first = 0; first < kLanes; first += kDoubles) {
        const auto lane = [&](auto k) { return static_cast<int>(first + k); };
        const Doubles px([&](auto k) { return block.x_of(lane(k)) + 0.5; });
        const Doubles py([&](auto k) { return block.y_of(lane(k)) + 0.5; });
        const SceneRays rays(view, frame, px, py);
        const Doubles t = entry(rays);
        origin.store(first, rays.origin + rays.direction * t);
        direction.store(first, rays.direction);
        for (std::size_t k = 0; k < kDoubles; ++k)
            far[first + k] = t[k] >= 0 && block.holds(lane(k)) ? kFar : -1.0f;
    }
    RayPacket rays;
    rays.origin = origin.high(), rays.origin_low = origin.low();
    rays.direction = direction.high(), rays.direction_low = direction.low();
    rays.far = FloatV(far.data(), stdx::element_aligned);
    return rays;
}

}  // namespace

RayPacket primary_rays(const PixelView& view, const SceneFrame& frame, const PixelBlock& block) {
    return rays_through(view, frame, block, scene_entry);
}

RayPacket rays_to_ground(const PixelView& view, const SceneFrame& frame, const PixelBlock& block) {
    return rays_through(view, frame, block, far_entry);
}

}  // namespace slim
