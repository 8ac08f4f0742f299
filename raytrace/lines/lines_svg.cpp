#include "raytrace/lines/lines_svg.h"

#include "raytrace/lines/stroke.h"
#include "raytrace/svg_color.h"

#include <algorithm>
#include <cstdio>

namespace slim {
namespace {

constexpr double kMmPerPixel = 25.4 / 96;

std::string number(double value, int digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

std::string mm(float px) { return number(kMmPerPixel * static_cast<double>(px), 3); }

std::string path_of(const FeatureLine& line, int width, int height) {
    std::string d;
    for (const LinePoint& p : line.points) {
        d += d.empty() ? "M" : " ";
        d += mm(p.x) + "," + mm(p.y);
    }
    if (line.closed) d += " Z";
    return "    <path d=\"" + d + "\" stroke-width=\"" + mm(stroke_width(line, width, height)) +
           "\"/>\n";
}

}  // namespace

std::string lines_svg(std::span<const FeatureLine> lines, std::span<const LineKind> kinds, int width, int height,
                      const PixelWindow& window) {
    const std::string w = number(kMmPerPixel * window.width, 3), h = number(kMmPerPixel * window.height, 3);
    const auto from = [](int px) { return px == 0 ? std::string("0") : number(kMmPerPixel * px, 3); };
    std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"" + w +
                      "mm\" height=\"" + h + "mm\" viewBox=\"" + from(window.x) + " " + from(window.y) + " " + w + " " + h +
                      "\" fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n";
    for (const LineKind kind : kinds) {
        const LineStyle style = line_style(kind);
        out += std::string("  <g id=\"") + style.group + "\" stroke=\"" + hex_color(style.srgb) +
               "\">\n";
        for (const FeatureLine& line : lines)
            if (line.kind == kind) out += path_of(line, width, height);
        out += "  </g>\n";
    }
    return out + "</svg>\n";
}

}  // namespace slim
