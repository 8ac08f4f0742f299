#include "raytrace/scale_bar.h"

#include "raytrace/font.h"
#include "raytrace/panel.h"

#include <cmath>
#include <cstdio>

namespace slim {
namespace {

/// Three digits, or all before the point: "1000", not "1e+03".
std::string text_of(double value) {
    char text[32];
    std::snprintf(text, sizeof text, value >= 999.5 && value < 1e7 ? "%.0f" : "%.3g", value);
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

/// What is written, and the bar's length in pixels.
struct Words {
    std::string length, pixel;
    float bar;

    Words(const ScaleBar& scale, int width) {
        const std::string unit = scale.unit.empty() ? "units" : scale.unit;
        const double units = scale_bar_length(scale, width);
        length = text_of(units) + " " + unit;
        pixel = "1 px = " + text_of(1 / scale.px_per_unit) + " " + unit;
        bar = static_cast<float>(units * scale.px_per_unit);
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

PixelBox scale_bar_box(const ScaleBar& scale, int width, int height, LegendPlace corner) {
    const Layout l(width, height);
    const Words words(scale, width);
    const float box_width = 2 * l.padding + std::max({words.bar, text_width(words.length, l.text),
                                                      text_width(words.pixel, l.text)});
    if (box_width > 0.6f * static_cast<float>(width) ||
        l.height > kMostHeight * static_cast<float>(height))
        return {};
    const auto w = static_cast<float>(width), h = static_cast<float>(height);
    const float x0 = is_left(corner) ? l.margin : std::floor(w - l.margin - box_width);
    const float y0 = is_top(corner) ? l.margin : h - l.margin - l.height;
    return {x0, y0, x0 + box_width, y0 + l.height};
}

float scale_bar_most(int width, int height) {
    const Layout l(width, height);
    const float words = text_width("1 px = 0.000123 units", l.text);
    return l.margin + 2 * l.padding + std::max(0.3f * static_cast<float>(width), words);
}

bool burn_scale_bar(const ScaleBar& scale, const Canvas& canvas, LegendPlace corner) {
    const PixelBox box = scale_bar_box(scale, canvas.width, canvas.height, corner);
    if (!(box.x1 > box.x0)) return false;
    const float u = text_unit(canvas.width, canvas.height);
    const Layout l(canvas.width, canvas.height);
    const Words words(scale, canvas.width);
    fill_panel(canvas, box, std::round(10 * u));
    const float x = box.x0 + l.padding, y = std::round(box.y0 + l.padding + l.text.cap_height);
    draw_text(canvas, words.length, x, y, l.text);
    const float top = y + std::round(10 * u), pen = std::max(1.0f, std::round(2 * u)),
                tick = std::round(10 * u);
    fill_box(canvas, {x, top + (tick - pen) / 2, x + words.bar, top + (tick + pen) / 2}, kInk);
    for (const float at : {x, x + words.bar - pen})
        fill_box(canvas, {at, top, at + pen, top + tick}, kInk);
    draw_text(canvas, words.pixel, x, top + tick + l.line - std::round(4 * u), l.text);
    return true;
}

}  // namespace slim
