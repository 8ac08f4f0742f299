#include "raytrace/legend_below.h"

#include "raytrace/font.h"
#include "raytrace/legend_numbers.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace slim {
namespace {

/// Sizes in pixels, as in the upright legend.
struct Layout {
    float unit, padding, tick, gap, tip, bar_width, bar_height;
    TextStyle title, label;
    std::vector<double> ticks;
    std::vector<std::string> texts;
    PixelBox panel;
    float bar_x, bar_y;

    Layout(const Legend& legend, int width, int height) : ticks(legend_ticks(legend.range)) {
        const float u = unit = text_unit(width, height);
        padding = std::round(18 * u), tick = std::round(7 * u), gap = 8 * u;
        tip = std::round(16 * u), bar_width = std::round(330 * u), bar_height = std::round(24 * u);
        title = {15 * u, kInk, 0.15f}, label = {14 * u, kInk, 0.12f};
        for (const double t : ticks) texts.push_back(tick_label(t, ticks));
        const float overhang = std::max(tip, widest() / 2);
        const float notes = legend.high_note.empty() && legend.low_note.empty()
                                ? 0
                                : 1.85f * label.cap_height;
        const float w = std::round(
            2 * padding + std::max({bar_width + 2 * overhang,
                                    text_width(heading(legend), title), notes_width(legend)}));
        const float head = title.cap_height + notes + std::round(12 * u);
        const float h =
            std::round(2 * padding + head + bar_height + tick + gap + label.cap_height);
        const float margin = std::round(24 * u);
        const float x1 = static_cast<float>(width) - margin,
                    y1 = static_cast<float>(height) - margin;
        panel = {x1 - w, y1 - h, x1, y1};
        bar_x = std::round(panel.x0 + (w - bar_width) / 2);
        bar_y = std::round(panel.y0 + padding + head);
    }

    static std::string heading(const Legend& legend) {
        return legend.unit.empty() ? legend.title : legend.title + ", " + legend.unit;
    }
    float x_of(const Legend& legend, double value) const {
        const double t = (value - legend.range.lo) / (legend.range.hi - legend.range.lo);
        return bar_x + bar_width * static_cast<float>(t);
    }

private:
    float widest() const {
        float most = 0;
        for (const std::string& text : texts) most = std::max(most, text_width(text, label));
        return most;
    }
    float notes_width(const Legend& legend) const {
        return text_width(legend.low_note, label) + 3 * gap + text_width(legend.high_note, label);
    }
};

/// Triangle on the edge x = base of the bar, its tip `width` away (negative: to the left).
void fill_tip(const Canvas& canvas, const Layout& l, float base, float width, const Vec3f& color) {
    const float cy = l.bar_y + l.bar_height / 2;
    const PixelBox box{std::min(base, base + width), l.bar_y - 1, std::max(base, base + width),
                       l.bar_y + l.bar_height + 1};
    for_pixels(canvas, box, [&](float x, float y, float* p) {
        const float left = 1 - (x - base) / width;  // 1 at the bar, 0 at the tip
        const float inside = left * l.bar_height / 2 - std::abs(y - cy);
        blend_pixel(p, color, std::clamp(inside + 0.5f, 0.0f, 1.0f));
    });
}

void draw_ticks(const Canvas& canvas, const Legend& legend, const Layout& l) {
    const float edge = l.bar_y + l.bar_height, half = std::max(0.5f, 0.75f * l.unit);
    std::vector<NumberSpan> spans;
    for (std::size_t i = 0; i < l.ticks.size(); ++i) {
        const float x = l.x_of(legend, l.ticks[i]), half_text = text_width(l.texts[i], l.label) / 2;
        spans.push_back({x - half_text, x + half_text});
    }
    const NumberChoice chosen = numbers_apart(l.ticks, spans, l.gap);
    for (std::size_t i = 0; i < l.ticks.size(); ++i) {
        const float x = l.x_of(legend, l.ticks[i]);
        fill_box(canvas, {x - half, edge, x + half, edge + l.tick}, kInk);
        if (chosen.has(i))
            draw_text(canvas, l.texts[i], spans[i].from,
                      edge + l.tick + l.gap + l.label.cap_height, l.label);
    }
}

}  // namespace

PixelBox box_below(const Legend& legend, int width, int height) {
    return Layout(legend, width, height).panel;
}

void burn_below(const Legend& legend, const Canvas& canvas) {
    const Layout l(legend, canvas.width, canvas.height);
    fill_panel(canvas, l.panel, std::round(10 * l.unit));
    const auto color_at = [&](float share) {
        return legend.map->linear(place_of_share(legend.range, static_cast<double>(share)));
    };
    const float end = l.bar_x + l.bar_width;
    for_pixels(canvas, {l.bar_x, l.bar_y, end, l.bar_y + l.bar_height},
               [&](float x, float, float* p) {
                   blend_pixel(p, color_at((x - l.bar_x) / l.bar_width), 1);
               });
    if (legend.clipped_low) fill_tip(canvas, l, l.bar_x, -l.tip, color_at(0));
    if (legend.clipped_high) fill_tip(canvas, l, end, l.tip, color_at(1));
    draw_ticks(canvas, legend, l);
    draw_text(canvas, Layout::heading(legend), l.panel.x0 + l.padding,
              l.panel.y0 + l.padding + l.title.cap_height, l.title);
    const float baseline = l.bar_y - std::round(9 * l.unit);
    draw_text(canvas, legend.low_note, l.panel.x0 + l.padding, baseline, l.label);
    draw_text(canvas, legend.high_note,
              l.panel.x1 - l.padding - text_width(legend.high_note, l.label), baseline, l.label);
}

}  // namespace slim
