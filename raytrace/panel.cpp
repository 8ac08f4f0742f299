#include "raytrace/panel.h"

namespace slim {
namespace {

constexpr Vec3f kPaper{1, 1, 1};
constexpr float kPaperAlpha = 0.86f;

}  // namespace

/// Smooth edges by the signed distance to the rounded rectangle.
void fill_panel(const Canvas& canvas, const PixelBox& box, float radius) {
    const float width = box.x1 - box.x0, height = box.y1 - box.y0;
    const float cx = box.x0 + width / 2, cy = box.y0 + height / 2;
    for_pixels(canvas, box, [&](float x, float y, float* p) {
        const float dx = std::abs(x - cx) - width / 2 + radius;
        const float dy = std::abs(y - cy) - height / 2 + radius;
        const float outside = std::hypot(std::max(dx, 0.0f), std::max(dy, 0.0f)) +
                              std::min(std::max(dx, dy), 0.0f) - radius;
        blend_pixel(p, kPaper, kPaperAlpha * std::clamp(0.5f - outside, 0.0f, 1.0f));
    });
}

void fill_box(const Canvas& canvas, const PixelBox& box, const Vec3f& color) {
    for_pixels(canvas, box, [&](float x, float y, float* p) {
        const float in_x = std::clamp(std::min(x - box.x0, box.x1 - x) + 0.5f, 0.0f, 1.0f);
        const float in_y = std::clamp(std::min(y - box.y0, box.y1 - y) + 0.5f, 0.0f, 1.0f);
        blend_pixel(p, color, in_x * in_y);
    });
}

float text_unit(int width, int height) {
    return std::max(static_cast<float>(std::min(width, height)) / 1000, 0.5f);
}

}  // namespace slim
