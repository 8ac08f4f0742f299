#include "raytrace/height_label.h"

#include "raytrace/font.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr Vec3f kEdge{0.86f, 0.84f, 0.79f};  ///< of the sheet in the sun
constexpr Vec3f kText{0.06f, 0.026f, 0.009f};  ///< of the lines, darker: its strokes are thinner
constexpr float kWeight = 0.14f, kEdgeWeight = 0.5f, kEdgeOpacity = 0.7f;

}  // namespace

float seen_beside(const HeightLabel& label, float x, float y) {
    const float dx = x - label.x, dy = y - label.y;
    const float c = std::cos(label.angle_rad), s = std::sin(label.angle_rad);
    const float along = std::abs(dx * c + dy * s) - label.half_length();
    const float across = std::abs(dy * c - dx * s) - label.half_height();
    return std::clamp(std::max(along, across) + 0.5f, 0.0f, 1.0f);
}

std::vector<const HeightLabel*> labels_near(std::span<const HeightLabel> labels, float y) {
    std::vector<const HeightLabel*> near;
    for (const HeightLabel& label : labels)
        if (std::abs(y - label.y) < std::hypot(label.half_length(), label.half_height()) + 1)
            near.push_back(&label);
    return near;
}

void draw_height_labels(std::span<const HeightLabel> labels, const Canvas& canvas) {
    for (const HeightLabel& label : labels) {
        draw_turned_text(canvas, label.text, label.x, label.y, label.angle_rad,
                         {label.cap_height, kEdge, kEdgeWeight, kEdgeOpacity});
        draw_turned_text(canvas, label.text, label.x, label.y, label.angle_rad,
                         {label.cap_height, kText, kWeight});
    }
}

}  // namespace slim
