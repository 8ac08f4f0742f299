#pragma once

namespace slim {

/// Share of its size that the flux of a shape's normals about its centre makes where it has an
/// outside: a sphere 1, a wall or a terrain next to nothing.
inline constexpr double kClearFlux = 0.15;

/// |sum of the normals|, each times its area or all alike, over the sum of the areas, below which a
/// shape is closed but for small holes: of a bowl 0.5.
inline constexpr double kSmallHole = 0.25;

}  // namespace slim
