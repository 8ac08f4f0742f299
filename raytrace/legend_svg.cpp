#include "raytrace/legend.h"

#include "raytrace/svg_color.h"
#include "raytrace/svg_text.h"
#include "slim/base/check.h"
#include "slim/base/markup.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <vector>

namespace slim {
namespace {

// Millimetres.
constexpr double kLeastWidth = 44, kFont = 3.4, kBarX = 4, kBarWidth = 6, kBarHeight = 60, kTip = 3,
                 kBarY = 24;
constexpr double kHeight = kBarY + kBarHeight + 13;
constexpr int kStops = 33;

void write_text(std::ostream& out, double x, double y, const std::string& text,
                const char* weight = "normal") {
    if (text.empty()) return;
    out << "  <text x=\"" << x << "\" y=\"" << y << "\" font-weight=\"" << weight << "\">"
        << escaped_markup(text) << "</text>\n";
}

/// The colour of the value at a height of the bar, 0 to 1; of the screen, where the picture's
/// legend has light.
Vec3f bar_color(const Legend& legend, double height) {
    return legend.map->srgb(place_of_share(legend.range, height));
}

/// Heights of the gradient's stops: even ones, and that of 0, where the sides of a diverging map
/// may differ in scale.
std::vector<double> stop_heights(const ValueRange& r) {
    std::vector<double> heights;
    for (int i = 0; i < kStops; ++i) heights.push_back(static_cast<double>(i) / (kStops - 1));
    if (r.about_zero && r.lo < 0 && r.hi > 0 && r.lo != -r.hi)
        heights.push_back(-r.lo / (r.hi - r.lo));
    std::sort(heights.begin(), heights.end());
    return heights;
}

void write_gradient(std::ostream& out, const Legend& legend) {
    out << "  <defs><linearGradient id=\"bar\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">\n";
    for (const double height : stop_heights(legend.range))
        out << "    <stop offset=\"" << height << "\" stop-color=\""
            << hex_color(bar_color(legend, height)) << "\"/>\n";
    out << "  </linearGradient></defs>\n";
}

void write_tip(std::ostream& out, double base, double tip, const Vec3f& srgb) {
    out << "  <path d=\"M" << kBarX << ' ' << base << " L" << kBarX + kBarWidth << ' ' << base
        << " L" << kBarX + kBarWidth / 2 << ' ' << base + tip << " Z\" fill=\"" << hex_color(srgb)
        << "\"/>\n";
}

void write_ticks(std::ostream& out, const Legend& legend) {
    const std::vector<double> ticks = legend_ticks(legend.range);
    for (const double value : ticks) {
        const double t = (value - legend.range.lo) / (legend.range.hi - legend.range.lo);
        const double y = kBarY + kBarHeight * (1 - t), x = kBarX + kBarWidth;
        out << "  <path d=\"M" << x << ' ' << y
            << " h1.5\" stroke=\"#1a1b1e\" stroke-width=\"0.25\"/>\n";
        write_text(out, x + 2.5, y + 1.2, tick_label(value, ticks));
    }
}

/// kLeastWidth, or more where a line of words needs it.
double width_of(const Legend& legend) {
    double words = svg_text_width(legend.title, kFont, true);
    for (const std::string& text : {legend.unit, legend.high_note, legend.low_note})
        words = std::max(words, svg_text_width(text, kFont));
    return std::max(kLeastWidth, std::ceil(2 * kBarX + words));
}

}  // namespace

std::string legend_svg(const Legend& legend) {
    SLIM_CHECK(legend.map != nullptr, ==, true);
    SLIM_CHECK(legend.range.lo, <, legend.range.hi);
    std::ostringstream out;
    const double width = width_of(legend);
    out << "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"" << width
        << "mm\" height=\"" << kHeight << "mm\" viewBox=\"0 0 " << width << ' ' << kHeight
        << "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"" << kFont
        << "\" fill=\"#1a1b1e\">\n";
    write_gradient(out, legend);
    out << "  <rect x=\"" << kBarX << "\" y=\"" << kBarY << "\" width=\"" << kBarWidth
        << "\" height=\"" << kBarHeight << "\" fill=\"url(#bar)\"/>\n";
    const double bottom = kBarY + kBarHeight;
    if (legend.clipped_high) write_tip(out, kBarY, -kTip, bar_color(legend, 1));
    if (legend.clipped_low) write_tip(out, bottom, kTip, bar_color(legend, 0));
    write_ticks(out, legend);
    write_text(out, kBarX, 6, legend.title, "bold");
    write_text(out, kBarX, 11, legend.unit);
    write_text(out, kBarX, kBarY - kTip - 1.5, legend.high_note);
    write_text(out, kBarX, bottom + kTip + 4.5, legend.low_note);
    out << "</svg>\n";
    return out.str();
}

}  // namespace slim
