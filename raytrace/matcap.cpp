#include "raytrace/matcap.h"

#include "slim/base/check.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

/// Of the ball's radius that is looked at: pictures are often smoothed into their background at the
/// rim.
constexpr float kRim = 0.985f;
constexpr int kSize = 256;

/// Towards the middle of the picture by the same angle as the eye is from the axis.
Vec3f seen_from_eye(const Vec3f& n, const Vec3f& e) {
    // The rotation that takes e to (0, 0, 1); e.z > 0 for all that a camera sees.
    const float k = 1 / (1 + e.z);
    const float along = e.x * n.x + e.y * n.y;
    return {n.x - e.x * (n.z + along * k), n.y - e.y * (n.z + along * k), along + e.z * n.z};
}

float smooth(float from, float to, float x) {
    const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

Vec3f glazed_color(const Vec3f& n) {
    const Vec3f clay{0.42f, 0.16f, 0.085f}, dark{0.055f, 0.030f, 0.030f}, rim{0.32f, 0.42f, 0.55f};
    const float key = dot(n, normalized(Vec3f{-0.5f, 0.65f, 0.6f}));
    const float lit = smooth(-0.55f, 1.0f, key);
    Vec3f color = dark * (1 - lit) + clay * (1.5f * lit);
    const float edge = 1 - n.z;
    color += rim * (0.8f * edge * edge * edge * smooth(-0.6f, 0.5f, -key));
    // A window and its mirror image on the far side.
    color += Vec3f{1, 0.98f, 0.95f} *
             (0.6f * smooth(0.90f, 0.99f, dot(n, normalized(Vec3f{-0.38f, 0.52f, 0.77f}))));
    color += Vec3f{0.9f, 0.95f, 1} *
             (0.10f * smooth(0.90f, 0.99f, dot(n, normalized(Vec3f{0.55f, -0.45f, 0.70f}))));
    return color;
}

}  // namespace

Matcap::Matcap(int width, int height, std::vector<float> rgb)
    : width_(width), height_(height), rgb_(std::move(rgb)) {
    SLIM_CHECK(rgb_.size(), ==,
               3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

Matcap Matcap::glazed() {
    std::vector<float> rgb;
    rgb.reserve(3 * std::size_t{kSize} * kSize);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            Vec3f n{(2 * static_cast<float>(x) + 1) / kSize - 1,
                    1 - (2 * static_cast<float>(y) + 1) / kSize, 0};
            if (sq_length(n) > 1) n = normalized(n);
            n.z = std::sqrt(std::max(0.0f, 1 - sq_length(n)));
            const Vec3f c = glazed_color(n);
            rgb.insert(rgb.end(), {c.x, c.y, c.z});
        }
    return Matcap(kSize, kSize, std::move(rgb));
}

Vec3f Matcap::color(const Vec3f& normal, const Vec3f& toward_eye) const {
    const Vec3f n = seen_from_eye(normal, toward_eye);
    const float x = std::clamp((0.5f + 0.5f * kRim * n.x) * static_cast<float>(width_) - 0.5f, 0.0f,
                               static_cast<float>(width_ - 1));
    const float y = std::clamp((0.5f - 0.5f * kRim * n.y) * static_cast<float>(height_) - 0.5f,
                               0.0f, static_cast<float>(height_ - 1));
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, width_ - 1), y1 = std::min(y0 + 1, height_ - 1);
    const float s = x - static_cast<float>(x0), t = y - static_cast<float>(y0);
    const auto channel = [&](int c) {
        return (texel(x0, y0)[c] * (1 - s) + texel(x1, y0)[c] * s) * (1 - t) +
               (texel(x0, y1)[c] * (1 - s) + texel(x1, y1)[c] * s) * t;
    };
    return {channel(0), channel(1), channel(2)};
}

}  // namespace slim
