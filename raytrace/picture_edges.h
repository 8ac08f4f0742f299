#pragma once

#include "raytrace/picture.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// How far a pixel may differ from one that it touches: 1/16 of the way from black to white, as the
/// eye counts it (square roots of linear light; notes/0001).
inline constexpr float kEdgeContrast = 0.0625f;

/// Marks (1) every pixel that differs from one of its eight neighbours by more than `contrast` in
/// any channel, alpha among them, both of the two; 0 elsewhere. What it finds are outlines, folds,
/// lines, thin parts and strong changes of colour; nothing is known of what lies between the
/// pixels' middles.
///
/// covered  if given, 0 or 1 for each pixel: at 0 the picture is 0 in all channels, and need not be
///          read
/// cost     O(pixels), rows in parallel
std::vector<std::uint8_t> edge_pixels(const Picture& picture, float contrast = kEdgeContrast,
                                      std::span<const std::uint8_t> covered = {});

}  // namespace slim
