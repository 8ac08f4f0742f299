#include "raytrace/stripes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {

float reflected_stripes(const Vec3f& n, const Vec3f& v) {
    constexpr float kSharpness = 2.5f;  // of the sine: its slope at an edge is pi a stripe
    const Vec3f r = n * (2 * dot(n, v)) - v;
    const float stripe =
        std::atan2(r.x, r.z) * (kReflectionStripes / (2 * std::numbers::pi_v<float>));
    const float wave = kSharpness * std::sin(std::numbers::pi_v<float> * (stripe + 0.5f));
    const float lamp = 0.5f + 0.5f * std::clamp(wave, -1.0f, 1.0f);
    // Some light from the eye, so that the form shows within a stripe.
    return (0.03f + 0.82f * lamp) * (0.55f + 0.45f * std::max(0.0f, dot(n, v)));
}

}  // namespace slim
