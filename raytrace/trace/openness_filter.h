#pragma once

#include "raytrace/surface_light.h"

#include <array>
#include <span>
#include <vector>

namespace slim {

/// How far the filter looks, in pixels.
inline constexpr int kOpennessReach = 2;

/// What positions' floats lack, as TracedPlanes::position_low has it; empty where nothing.
using PositionRest = std::array<std::vector<float>, 3>;

/// Openness by `samples` rays per pixel, each replaced by a mean over 5 x 5 pixels in which every
/// place of interleaved samples (SampleGrid) counts alike. What counts less, down to nothing:
/// another surface (by its plane and its normal), and what differs by more than such samples do
/// from one another. So edges stay, and the more samples the less is averaged. Pixels of a window
/// that lie kOpennessReach inside are those of the whole picture, to the bit.
///
/// `planes` must hold positions and normals. cost O(25 pixels) in parallel
std::vector<float> filtered_openness(const SurfacePlanes& planes, std::span<const float> open,
                                     int samples, const PositionRest& rest = {});

}  // namespace slim
