#include "raytrace/key.h"

#include "raytrace/font.h"
#include "raytrace/panel.h"
#include "raytrace/svg_color.h"
#include "raytrace/svg_text.h"
#include "slim/base/markup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace slim {
namespace {

struct Layout {
    PixelBox panel;
    float unit, padding, line, swatch;
    TextStyle title, text;
};

Layout layout_of(const Key& key, LegendPlace place, int width, int height) {
    Layout l{};
    const float u = l.unit = text_unit(width, height);
    l.padding = std::round(16 * u), l.line = std::round(26 * u), l.swatch = std::round(16 * u);
    l.title = {15 * u, kInk, 0.15f}, l.text = {14 * u, kInk, 0.12f};
    float words = text_width(key.title, l.title);
    for (const Key::Row& row : key.rows)
        words = std::max(words,
                         text_width(row.text, l.text) + (row.has_swatch ? l.swatch + 10 * u : 0));
    const float w = std::round(2 * l.padding + words), margin = std::round(24 * u);
    const float h = std::round(2 * l.padding + l.title.cap_height +
                               l.line * static_cast<float>(key.rows.size()));
    const float x = is_left(place) ? margin : static_cast<float>(width) - margin - w;
    const float y = is_top(place) ? margin : static_cast<float>(height) - margin - h;
    l.panel = {x, y, x + w, y + h};
    return l;
}

bool has_room(const Layout& l, int width, int height) {
    return l.panel.x1 - l.panel.x0 <= 0.6f * static_cast<float>(width) &&
           l.panel.y1 - l.panel.y0 <= 0.75f * static_cast<float>(height);
}

Vec3f linear_of(const Vec3f& srgb) {
    return {linear_from_srgb(srgb.x), linear_from_srgb(srgb.y), linear_from_srgb(srgb.z)};
}

/// Millimetres: 70, or more where the words need it.
double svg_width(const Key& key) {
    constexpr double kLeast = 70, kMargin = 4, kFont = 3.4, kBesideSwatch = 6;
    double words = svg_text_width(key.title, kFont, true);
    for (const Key::Row& row : key.rows)
        words =
            std::max(words, svg_text_width(row.text, kFont) + (row.has_swatch ? kBesideSwatch : 0));
    return std::max(kLeast, std::ceil(2 * kMargin + words));
}

}  // namespace

LegendPlace best_key_place(const Key& key, const Picture& object, const PixelBox& taken) {
    constexpr std::array kPlaces{LegendPlace::right_bottom, LegendPlace::right_top,
                                 LegendPlace::left_top, LegendPlace::left_bottom};
    return least_covering(kPlaces, object, taken, [&](LegendPlace place) {
        return layout_of(key, place, object.width, object.height).panel;
    });
}

PixelBox key_box(const Key& key, LegendPlace place, int width, int height) {
    return layout_of(key, place, width, height).panel;
}

double key_share(const Key& key, int width, int height) {
    const Layout l = layout_of(key, LegendPlace::right_bottom, width, height);
    return has_room(l, width, height) ? 1 - static_cast<double>(l.panel.x0) / width : 0;
}

bool burn_key(const Key& key, const Canvas& canvas, LegendPlace place) {
    const Layout l = layout_of(key, place, canvas.width, canvas.height);
    if (!has_room(l, canvas.width, canvas.height)) return false;
    fill_panel(canvas, l.panel, std::round(10 * l.unit));
    const float x = l.panel.x0 + l.padding;
    float y = l.panel.y0 + l.padding + l.title.cap_height;
    draw_text(canvas, key.title, x, y, l.title);
    for (const Key::Row& row : key.rows) {
        y += l.line;
        const float top = std::round(y - 0.5f * (l.swatch + l.text.cap_height));
        if (row.has_swatch)
            fill_box(canvas, {x, top, x + l.swatch, top + l.swatch}, linear_of(row.srgb));
        draw_text(canvas, row.text, x + (row.has_swatch ? l.swatch + 10 * l.unit : 0), y, l.text);
    }
    return true;
}

std::string key_svg(const Key& key) {
    std::ostringstream out;
    const double height = 12 + 6.0 * static_cast<double>(key.rows.size()), width = svg_width(key);
    out << "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"" << width
        << "mm\" height=\"" << height << "mm\" viewBox=\"0 0 " << width << ' ' << height
        << "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"3.4\" fill=\"#1a1b1e\">\n"
        << "  <text x=\"4\" y=\"7\" font-weight=\"bold\">" << escaped_markup(key.title)
        << "</text>\n";
    double y = 7;
    for (const Key::Row& row : key.rows) {
        y += 6;
        if (row.has_swatch)
            out << "  <rect x=\"4\" y=\"" << y - 3.2 << "\" width=\"4\" height=\"4\" fill=\""
                << hex_color(row.srgb) << "\"/>\n";
        out << "  <text x=\"" << (row.has_swatch ? 10 : 4) << "\" y=\"" << y << "\">"
            << escaped_markup(row.text) << "</text>\n";
    }
    out << "</svg>\n";
    return out.str();
}

}  // namespace slim
