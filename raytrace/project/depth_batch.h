#pragma once

#include "raytrace/project/surfel_lanes.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/base/simd.h"

#include <cstddef>

namespace slim {

/// A surfel's depths in the tile's coordinate: zeta = zeta_c + tau / per_zeta.
struct DepthScale {
    float zeta_c, per_zeta, per_tau;

    [[gnu::always_inline]] FloatV tau_of(const FloatV& zeta) const {
        return (zeta - zeta_c) * per_zeta;
    }
    [[gnu::always_inline]] FloatV zeta_of(const FloatV& tau) const {
        return zeta_c + per_tau * tau;
    }
};

/// Depths of some surfels in a tile's coordinate, worked out side by side.
class DepthBatch {
public:
    /// Depth of the centre, radius and two further depths of the surfel in one lane.
    [[gnu::always_inline]] void set(std::size_t lane, double z_center, double radius, double first,
                                    double second) {
        z_[lane] = z_center, radius_[lane] = radius, first_[lane] = first, second_[lane] = second;
    }
    /// Of all lanes.
    [[gnu::always_inline]] void find(const TileDepths& d) {
        for (std::size_t k = 0; k < kLanes; k += kSurfelLanes) {
            const auto load = [&](const double* from) {
                return DoubleV(from + k, stdx::vector_aligned);
            };
            const auto store = [&](const DoubleV& x, float* to) {
                floats_of(x).copy_to(to + k, stdx::element_aligned);
            };
            const DoubleV offset = load(z_) - d.z_ref, radius = load(radius_);
            // z_c / z_ref
            const DoubleV ratio = 1.0 + offset * d.per_ref, sq_ratio = ratio * ratio;
            store(offset / ratio, zeta_c_);
            store(radius / sq_ratio, per_tau_);
            store(sq_ratio / radius, per_zeta_);
            store(d.zeta(stdx::max(load(first_) - d.z_ref, DoubleV(d.near))), at_first_);
            store(d.zeta(stdx::max(load(second_) - d.z_ref, DoubleV(d.near))), at_second_);
        }
    }
    DepthScale scale(std::size_t lane) const {
        return {zeta_c_[lane], per_zeta_[lane], per_tau_[lane]};
    }
    /// zeta of the further depths, or of the near plane if that is farther.
    float first(std::size_t lane) const { return at_first_[lane]; }
    float second(std::size_t lane) const { return at_second_[lane]; }

private:
    static_assert(kLanes % kSurfelLanes == 0);
    alignas(64) double z_[kLanes]{}, radius_[kLanes]{}, first_[kLanes]{}, second_[kLanes]{};
    alignas(64) float zeta_c_[kLanes], per_zeta_[kLanes], per_tau_[kLanes], at_first_[kLanes],
        at_second_[kLanes];
};

}  // namespace slim
