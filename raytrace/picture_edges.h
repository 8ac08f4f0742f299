#pragma once

#include "raytrace/picture.h"

#include <cstdint>
#include <vector>

namespace slim {

/// How far a pixel may differ from one that it touches: 1/16 of the way from black to white, as the
/// eye counts it (square roots of linear light; notes/0001).
inline constexpr float kEdgeContrast = 0.0625f;

/// Marks (1) every pixel that differs from one of its eight neighbours by more than `contrast` in
/// any channel, alpha among them, both of the two; 0 elsewhere. What it finds are outlines, folds,
/// lines, thin parts and strong changes of colour; nothing is known of what lies between the
/// pixels' middles.
/// cost  O(pixels), rows in parallel
std::vector<std::uint8_t> edge_pixels(const Picture& picture, float contrast = kEdgeContrast);

}  // namespace slim
