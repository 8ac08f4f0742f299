#include "raytrace/legend.h"

#include "raytrace/font.h"
#include "raytrace/legend_below.h"
#include "raytrace/legend_numbers.h"
#include "raytrace/panel.h"
#include "slim/base/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace slim {
namespace {

/// Sizes in pixels; `unit` is a thousandth of the picture's smaller side.
struct Layout {
    float unit, margin, padding, bar_width, bar_height, tick, gap, tip;
    TextStyle title, label;
    float x, y, width, height;  ///< the panel
    float bar_x, bar_y;
};

struct Labels {
    std::vector<double> ticks;
    std::vector<std::string> texts;
};

Labels labels_of(const Legend& legend) {
    Labels labels{legend_ticks(legend.range), {}};
    for (const double t : labels.ticks) labels.texts.push_back(tick_label(t, labels.ticks));
    return labels;
}

/// Triangle on the edge y = base of the bar, its tip `height` away (negative: upwards).
void fill_tip(const Canvas& canvas, const Layout& l, float base, float height, const Vec3f& color) {
    const float cx = l.bar_x + l.bar_width / 2;
    const PixelBox box{l.bar_x - 1, std::min(base, base + height), l.bar_x + l.bar_width + 1,
                       std::max(base, base + height)};
    for_pixels(canvas, box, [&](float x, float y, float* p) {
        const float left = 1 - (y - base) / height;  // 1 at the bar, 0 at the tip
        const float inside = left * l.bar_width / 2 - std::abs(x - cx);
        blend_pixel(p, color, std::clamp(inside + 0.5f, 0.0f, 1.0f));
    });
}

/// The colour of the value at a height of the bar, 0 to 1.
Vec3f bar_color(const Legend& legend, float height) {
    return legend.map->linear(place_of_share(legend.range, static_cast<double>(height)));
}

void fill_bar(const Canvas& canvas, const Layout& l, const Legend& legend) {
    for_pixels(canvas, {l.bar_x, l.bar_y, l.bar_x + l.bar_width, l.bar_y + l.bar_height},
               [&](float, float y, float* p) {
                   blend_pixel(p, bar_color(legend, 1 - (y - l.bar_y) / l.bar_height), 1);
               });
}

float widest(const std::vector<std::string>& texts, const TextStyle& style) {
    float width = 0;
    for (const std::string& text : texts) width = std::max(width, text_width(text, style));
    return width;
}

float line_height(const std::string& text, const TextStyle& style) {
    return text.empty() ? 0 : 1.85f * style.cap_height;
}

/// A note keeps clear of the label of the tick at its end of the bar.
float note_height(const std::string& text, const TextStyle& style) {
    return text.empty() ? 0 : 2.25f * style.cap_height;
}

/// The panel's upper edge.
float panel_top(LegendPlace place, float margin, float panel_height, int height) {
    const float rest = static_cast<float>(height) - panel_height;
    if (is_top(place)) return margin;
    if (is_bottom(place)) return rest - margin;
    return std::round(rest / 2);
}

/// Whether a panel takes so little of the width that it may take all of the height.
bool is_slim(const Layout& l, int width) {
    return l.width + l.margin <= 0.3f * static_cast<float>(width);
}

/// The most that a panel may take of the height, its margin left out.
float most_height(const Layout& l, int width, int height) {
    const auto h = static_cast<float>(height);
    return std::floor(is_slim(l, width) ? h - 2 * l.margin : 0.75f * h - l.margin);
}

/// A third of the picture's smaller side; shorter in low pictures, beside which there is room.
float bar_height(const Layout& l, float beside_bar, int width, int height) {
    const float usual = std::round(330 * l.unit), least = std::round(100 * l.unit);
    if (!is_slim(l, width)) return usual;
    return std::clamp(std::floor(most_height(l, width, height) - beside_bar), least, usual);
}

Layout layout_of(const Legend& legend, const Labels& labels, LegendPlace place, int width,
                 int height) {
    Layout l{};
    const float u = l.unit = text_unit(width, height);
    // Whole pixels for bar and panel keep their edges crisp.
    l.margin = std::round(24 * u), l.padding = std::round(18 * u);
    l.bar_width = std::round(30 * u), l.tick = std::round(7 * u), l.gap = 8 * u;
    l.tip = std::round(16 * u);
    l.title = {15 * u, kInk, 0.15f};
    l.label = {14 * u, kInk, 0.12f};
    const float ticks = l.bar_width + l.tick + l.gap + widest(labels.texts, l.label);
    const float words = std::max(text_width(legend.title, l.title),
                                 widest({legend.unit, legend.high_note, legend.low_note}, l.label));
    l.width = std::round(2 * l.padding + std::max(ticks, words));
    const float heading = line_height(legend.title, l.title) + line_height(legend.unit, l.label);
    const float beside_bar = 2 * l.padding + heading + 12 * u +
                             note_height(legend.high_note, l.label) +
                             note_height(legend.low_note, l.label) +
                             l.tip * static_cast<float>(legend.clipped_high + legend.clipped_low);
    l.bar_height = bar_height(l, beside_bar, width, height);
    l.height = std::round(beside_bar + l.bar_height);
    l.x = is_left(place) ? l.margin : static_cast<float>(width) - l.margin - l.width;
    l.y = panel_top(place, l.margin, l.height, height);
    l.bar_x = l.x + l.padding;
    l.bar_y =
        std::round(l.y + l.padding + heading + 12 * u + note_height(legend.high_note, l.label) +
                   (legend.clipped_high ? l.tip : 0));
    return l;
}

bool has_room(const Layout& l, int width, int height) {
    return l.width + l.margin <= 0.6f * static_cast<float>(width) &&
           l.height <= most_height(l, width, height);
}

void draw_words(const Canvas& canvas, const Legend& legend, const Layout& l) {
    float y = l.y + l.padding + l.title.cap_height;
    draw_text(canvas, legend.title, l.bar_x, y, l.title);
    y += line_height(legend.title, l.title);
    draw_text(canvas, legend.unit, l.bar_x, y, l.label);
    const float top = l.bar_y - (legend.clipped_high ? l.tip : 0);
    draw_text(canvas, legend.high_note, l.bar_x, top - 1.15f * l.label.cap_height, l.label);
    const float bottom = l.bar_y + l.bar_height + (legend.clipped_low ? l.tip : 0);
    draw_text(canvas, legend.low_note, l.bar_x, bottom + 2.15f * l.label.cap_height, l.label);
}

void draw_ticks(const Canvas& canvas, const Legend& legend, const Labels& labels, const Layout& l) {
    const float edge = l.bar_x + l.bar_width, half = std::max(0.5f, 0.75f * l.unit);
    const float half_cap = l.label.cap_height / 2;
    const auto y_of = [&](double value) {
        const double t = (value - legend.range.lo) / (legend.range.hi - legend.range.lo);
        return l.bar_y + l.bar_height * static_cast<float>(1 - t);
    };
    std::vector<NumberSpan> spans;
    for (const double t : labels.ticks) spans.push_back({-y_of(t) - half_cap, -y_of(t) + half_cap});
    const NumberChoice chosen = numbers_apart(labels.ticks, spans, half_cap);
    for (std::size_t i = 0; i < labels.ticks.size(); ++i) {
        const float y = y_of(labels.ticks[i]);
        fill_box(canvas, {edge, y - half, edge + l.tick, y + half}, kInk);
        if (chosen.has(i))
            draw_text(canvas, labels.texts[i], edge + l.tick + l.gap, y + half_cap, l.label);
    }
}

}  // namespace

PixelBox legend_box(const Legend& legend, LegendPlace place, int width, int height) {
    if (place == LegendPlace::below) return box_below(legend, width, height);
    const Layout l = layout_of(legend, labels_of(legend), place, width, height);
    return {l.x, l.y, l.x + l.width, l.y + l.height};
}

LegendPlace best_legend_place(const Legend& legend, const Picture& object,
                              const PixelBox& taken) {
    using P = LegendPlace;
    constexpr std::array kUpright{P::right, P::right_top, P::right_bottom,
                                  P::left,  P::left_top,  P::left_bottom};
    // Of a picture that is full, the middle of a side shows more of what matters than a corner.
    constexpr std::array kOver{P::below,    P::right_bottom, P::right_top, P::left_bottom,
                               P::left_top, P::right,        P::left};
    const auto box_at = [&](P place) {
        return legend_box(legend, place, object.width, object.height);
    };
    const P best = least_covering(kUpright, object, taken, box_at);
    if (hidden_by(box_at(best), object, taken) <= 0) return best;
    const bool fits_below = box_at(P::below).x0 >= 0 && box_at(P::below).y0 >= 0;
    return least_covering(std::span(kOver).subspan(fits_below ? 0 : 1), object, taken, box_at);
}

double legend_share(const Legend& legend, int width, int height) {
    const Layout l = layout_of(legend, labels_of(legend), LegendPlace::right, width, height);
    return has_room(l, width, height) ? static_cast<double>(l.width + l.margin) / width : 0;
}

bool burn_legend(const Legend& legend, const Canvas& canvas, LegendPlace place) {
    SLIM_CHECK(legend.map != nullptr, ==, true);
    SLIM_CHECK(legend.range.lo, <, legend.range.hi);
    const Labels labels = labels_of(legend);
    const Layout l = layout_of(legend, labels, place, canvas.width, canvas.height);
    if (!has_room(l, canvas.width, canvas.height)) return false;
    if (place == LegendPlace::below) {
        burn_below(legend, canvas);
        return true;
    }
    fill_panel(canvas, {l.x, l.y, l.x + l.width, l.y + l.height}, std::round(10 * l.unit));
    fill_bar(canvas, l, legend);
    if (legend.clipped_high) fill_tip(canvas, l, l.bar_y, -l.tip, bar_color(legend, 1));
    if (legend.clipped_low)
        fill_tip(canvas, l, l.bar_y + l.bar_height, l.tip, bar_color(legend, 0));
    draw_ticks(canvas, legend, labels, l);
    draw_words(canvas, legend, l);
    return true;
}

}  // namespace slim
