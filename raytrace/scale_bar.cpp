#include "raytrace/scale_bar.h"

#include "raytrace/font.h"
#include "raytrace/panel.h"

#include <cmath>
#include <cstdio>

namespace slim {
namespace {

std::string text_of(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

/// Of the panel, in pixels.
struct Layout {
    float padding, margin, line, height;
    TextStyle text;

    Layout(int width, int picture_height) {
        const float u = text_unit(width, picture_height);
        padding = std::round(16 * u), margin = std::round(24 * u), line = std::round(26 * u);
        text = {14 * u, kInk, 0.12f};
        height = 2 * padding + text.cap_height + line + std::round(16 * u);
    }
};

constexpr float kMostHeight = 0.4f;  // of the picture

}  // namespace

double scale_bar_share(int width, int height) {
    const Layout l(width, height);
    const auto picture = static_cast<float>(height);
    return l.height > kMostHeight * picture ? 0
                                            : static_cast<double>((l.height + l.margin) / picture);
}

double scale_bar_length(const ScaleBar& scale, int width) {
    const double most = 0.3 * width / scale.px_per_unit;
    const double power = std::pow(10.0, std::floor(std::log10(most)));
    const double digit = most / power;
    return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

bool burn_scale_bar(const ScaleBar& scale, const Canvas& canvas) {
    const float u = text_unit(canvas.width, canvas.height);
    const auto [padding, margin, line, height, text] = Layout(canvas.width, canvas.height);
    const std::string unit = scale.unit.empty() ? "units" : scale.unit;
    const double length = scale_bar_length(scale, canvas.width);
    const std::string words = text_of(length, 3) + " " + unit;
    const std::string pixel = "1 px = " + text_of(1 / scale.px_per_unit, 3) + " " + unit;
    const auto bar = static_cast<float>(length * scale.px_per_unit);
    const float width =
        2 * padding + std::max({bar, text_width(words, text), text_width(pixel, text)});
    if (width > 0.6f * static_cast<float>(canvas.width) ||
        height > kMostHeight * static_cast<float>(canvas.height))
        return false;
    const float y0 = static_cast<float>(canvas.height) - margin - height;
    fill_panel(canvas, {margin, y0, margin + width, y0 + height}, std::round(10 * u));
    const float x = margin + padding, y = std::round(y0 + padding + text.cap_height);
    draw_text(canvas, words, x, y, text);
    const float top = y + std::round(10 * u), pen = std::max(1.0f, std::round(2 * u)),
                tick = std::round(10 * u);
    fill_box(canvas, {x, top + (tick - pen) / 2, x + bar, top + (tick + pen) / 2}, kInk);
    for (const float at : {x, x + bar - pen})
        fill_box(canvas, {at, top, at + pen, top + tick}, kInk);
    draw_text(canvas, pixel, x, top + tick + line - std::round(4 * u), text);
    return true;
}

}  // namespace slim
