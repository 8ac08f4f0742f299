#include "raytrace/lines/crossings.h"
#include "raytrace/stripes.h"
#include "slim/base/parallel.h"

#include <cmath>
#include <numbers>

namespace slim {
namespace {

/// Angle of the reflected view 2 (N.v) N - v about the picture's upright axis, in stripes: long
/// lamps that stand around the scene, at rest relative to the camera.
float stripe_at(const LineScene& s, std::size_t i) {
    const Vec3f v = normalized(s.toward_eye(i)), n = s.normal(i);
    const Vec3f r = n * (2 * dot(n, v)) - v;
    return std::atan2(dot(r, to_float(s.view.right)), -dot(r, to_float(s.view.forward))) *
           (kReflectionStripes / (2 * std::numbers::pi_v<float>));
}

}  // namespace

CrossingField reflection_crossings(const LineScene& s, const Sheets& sheets) {
    std::vector<float> stripe(s.buffer.n_pixels());
    const auto width = static_cast<std::size_t>(s.buffer.width);
    parallel_blocks(stripe.size(), width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (s.hit(i)) stripe[i] = stripe_at(s, i);
    });
    const auto weight = static_cast<float>(1 / s.diagonal);
    const auto find = [=, &stripe](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
        // Half a stripe off, so that no edge lies where the angle jumps from pi to -pi.
        const float fa = stripe[a] + 0.5f, fb = stripe[b] + 0.5f;
        const float level = std::fmax(std::floor(fa), std::floor(fb));
        if (std::floor(fa) == std::floor(fb) || std::fabs(fa - fb) > 1) return std::nullopt;
        return EdgeHit{(level - fa) / (fb - fa), weight};
    };
    return find_on_sheets(s, sheets, find);
}

}  // namespace slim
