#pragma once

namespace slim {

/// Share of its size that the flux of a shape's normals about its centre makes where it has an
/// outside: a sphere 1, a wall or a terrain next to nothing.
inline constexpr double kClearFlux = 0.15;

}  // namespace slim
