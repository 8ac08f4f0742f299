#pragma once

#include "slim/base/simd.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <limits>

namespace slim {

/// Vectors, one per lane.
struct LanesOfVec {
    FloatV x, y, z;

    LanesOfVec() = default;
    LanesOfVec(const FloatV& a, const FloatV& b, const FloatV& c) : x(a), y(b), z(c) {}
    explicit LanesOfVec(const Vec3f& v) : x(v.x), y(v.y), z(v.z) {}

    [[gnu::always_inline]] FloatV dot(const LanesOfVec& b) const {
        return x * b.x + y * b.y + z * b.z;
    }
    [[gnu::always_inline]] FloatV dot(const Vec3f& b) const { return x * b.x + y * b.y + z * b.z; }
    [[gnu::always_inline]] LanesOfVec cross(const LanesOfVec& b) const {
        return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x};
    }
    [[gnu::always_inline]] LanesOfVec operator+(const LanesOfVec& b) const {
        return {x + b.x, y + b.y, z + b.z};
    }
    [[gnu::always_inline]] LanesOfVec operator-(const LanesOfVec& b) const {
        return {x - b.x, y - b.y, z - b.z};
    }
    [[gnu::always_inline]] LanesOfVec operator-() const { return {-x, -y, -z}; }
    [[gnu::always_inline]] LanesOfVec operator*(const FloatV& s) const {
        return {x * s, y * s, z * s};
    }
    /// A vector of length 0 stays one.
    LanesOfVec unit() const {
        return *this *
               inverse_sqrt(stdx::max(dot(*this), FloatV(std::numeric_limits<float>::min())));
    }
    Vec3f at(int lane) const {
        const auto k = static_cast<std::size_t>(lane);
        return {x[k], y[k], z[k]};
    }
    void set(int lane, const Vec3f& v) {
        const auto k = static_cast<std::size_t>(lane);
        x[k] = v.x, y[k] = v.y, z[k] = v.z;
    }
};

[[gnu::always_inline]] inline LanesOfVec select_vec(const FloatV::mask_type& mask,
                                                    const LanesOfVec& a, const LanesOfVec& b) {
    return {select<FloatV>(mask, a.x, b.x), select<FloatV>(mask, a.y, b.y),
            select<FloatV>(mask, a.z, b.z)};
}

}  // namespace slim
