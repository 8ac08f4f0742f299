#pragma once

#include "raytrace/camera.h"
#include "slim/base/simd.h"
#include "slim/base/vec.h"
#include "slim/model/surfel.h"

#include <array>
#include <cstddef>

namespace slim {

/// What is worked out once a surfel and frame is in lanes, one surfel each, in doubles.
using DoubleV = stdx::native_simd<double>;
using Vec3D = Vec3<DoubleV>;
using FloatsOfDouble = LanesOfDouble<float>;
inline constexpr std::size_t kSurfelLanes = DoubleV::size();

[[gnu::always_inline]] inline FloatsOfDouble floats_of(const DoubleV& x) {
    return stdx::static_simd_cast<FloatsOfDouble>(x);
}

/// Smooth surfels side by side, or first sheets of sharp ones; camera axes.
struct SurfelLanes {
    Vec3D center;
    DoubleV radius;         ///< rho
    Vec3D e_u, e_v, e_w;    ///< their frames
    std::array<DoubleV, kMaxCoefficients> a;
};

/// Fills lanes one by one.
class SurfelBatch {
public:
    std::size_t size() const { return n_; }
    bool full() const { return n_ == kSurfelLanes; }
    void clear() { n_ = 0; }
    /// `c` is the surfel's centre in camera coordinates. Not when full.
    void add(const Vec3d& c, const Surfel& s) {
        std::size_t field = 0;
        const auto put = [&](double x) { v_[field++][n_] = x; };
        const auto put_vec = [&](const Vec3d& v) { put(v.x), put(v.y), put(v.z); };
        put_vec(c), put(s.support_radius);
        put_vec(s.frame.u_axis), put_vec(s.frame.v_axis), put_vec(s.frame.normal);
        for (const double a : s.polynomial.a) put(a);
        ++n_;
    }
    /// Not of none; lanes without a surfel repeat the last one.
    SurfelLanes lanes(const PixelView& view);

private:
    static constexpr std::size_t kFields = 13 + kMaxCoefficients;
    alignas(64) double v_[kFields][kSurfelLanes];
    std::size_t n_ = 0;
};

}  // namespace slim
