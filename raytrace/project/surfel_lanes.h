#pragma once

#include "raytrace/camera.h"
#include "slim/base/frame.h"
#include "slim/base/simd.h"
#include "slim/base/vec.h"
#include "slim/model/surfel.h"

#include <array>
#include <cstddef>
#include <span>

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
    /// `c` is the surfel's centre in camera coordinates; coefficients beyond those given are zero,
    /// as many for all. Not when full.
    template <class Float, std::size_t N>
    void add(const Vec3d& c, double radius, const Octahedral& normal,
             std::span<const Float, N> coefficients) {
        std::size_t field = 0;
        const auto put = [&](double x) { v_[field++][n_] = x; };
        put(c.x), put(c.y), put(c.z), put(radius), put(double{normal.s}), put(double{normal.t});
        for (const Float a : coefficients) put(double{a});
        ++n_;
    }
    /// Not of none; lanes without a surfel repeat the last one.
    SurfelLanes lanes(const PixelView& view);

private:
    static constexpr std::size_t kFields = 6 + kMaxCoefficients;
    alignas(64) double v_[kFields][kSurfelLanes]{};
    std::size_t n_ = 0;
};

}  // namespace slim
