#pragma once

#include "slim/model/surfel.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/wide_fit.h"

#include <array>
#include <cstddef>

namespace slim {

inline constexpr double kRungStep = 0.85;     ///< from rung to rung
inline constexpr std::size_t kRungs = 56;     ///< from a quarter of the diagonal down to 3e-5 of it
inline constexpr double kBiasGrowth = 3.67;   ///< of the squared bias from rung to
                                              ///< rung by theory: kRungStep^-8

/// The radius of a rung; 0 is the widest.
double rung_radius(std::size_t rung, double diagonal);

/// Wide fits about a leaf on the rungs [widest, narrowest];
/// the squared bias of wider ones is extrapolated.
struct BiasLadder {
    std::size_t widest = kRungs, narrowest = kRungs;  // kRungs: none
    std::array<float, kRungs> sq_bias{}, sq_error{};   ///< as WideFit has them
    std::array<float, kRungs> sq_noise{};              ///< across the surface
    std::array<float, kRungs> lift{}, sq_lift_error{};
    bool plain = false;  ///< the climb ended as the bias was plain: wider rungs have more
    bool has(std::size_t k) const { return widest <= k && k <= narrowest && widest < kRungs; }
};

/// Climbs from the narrowest rung that a leaf's fit of that noise allows until the bias is plain.
BiasLadder climb_ladder(const Surfel& leaf, double noise, const PointPyramid& points,
                        double diagonal, WideWork& work);

}  // namespace slim
