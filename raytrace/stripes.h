#pragma once

#include "slim/base/vec.h"

namespace slim {

/// Stripes around the whole horizon, lit and dark ones: lamps that stand upright around the scene,
/// at rest relative to the camera. Their edges are the reflection lines of raytrace/lines.
inline constexpr float kReflectionStripes = 24;

/// What the surface mirrors of these lamps: the angle of 2 (N.v) N - v about the picture's upright
/// axis (NUMERICS 5.4), dark to bright over an eighth of a stripe; linear grey. Unit vectors in
/// camera axes (right, up, back).
float reflected_stripes(const Vec3f& normal, const Vec3f& toward_eye);

}  // namespace slim
