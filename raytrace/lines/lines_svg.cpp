#include "raytrace/lines/lines_svg.h"

#include "raytrace/lines/stroke.h"
#include "raytrace/picture.h"
#include "raytrace/svg_color.h"

namespace slim {
namespace {

std::string path_of(const FeatureLine& line, int width, int height, const SvgScale& scale) {
    std::string d;
    for (const LinePoint& p : line.points) {
        d += d.empty() ? "M" : " ";
        d += scale.mm(p.x) + "," + scale.mm(p.y);
    }
    if (line.closed) d += " Z";
    return "    <path d=\"" + d + "\" stroke-width=\"" +
           scale.mm(stroke_width(line, width, height)) + "\"/>\n";
}

Vec3f srgb_of(const Vec3f& linear) {
    return {srgb_from_linear(linear.x), srgb_from_linear(linear.y), srgb_from_linear(linear.z)};
}

/// What light lines are seen on, behind the whole picture.
std::string background_of(const Background& background, int width, int height,
                          const SvgScale& scale) {
    const std::string top = hex_color(srgb_of(background.top)),
                      bottom = hex_color(srgb_of(background.bottom));
    const std::string size = " width=\"" + scale.mm(static_cast<float>(width)) + "\" height=\"" +
                             scale.mm(static_cast<float>(height)) + "\" stroke=\"none\"";
    if (top == bottom) return "  <rect id=\"background\"" + size + " fill=\"" + top + "\"/>\n";
    return "  <linearGradient id=\"shade\" x1=\"0\" y1=\"0\" x2=\"0\" y2=\"1\"><stop offset=\"0\" "
           "stop-color=\"" +
           top + "\"/><stop offset=\"1\" stop-color=\"" + bottom +
           "\"/></linearGradient>\n  <rect id=\"background\"" + size + " fill=\"url(#shade)\"/>\n";
}

}  // namespace

std::string lines_svg(std::span<const FeatureLine> lines, std::span<const LineKind> kinds,
                      int width, int height, const PixelWindow& window,
                      const Background& background, const SvgScale& scale) {
    std::string out = scale.opening(window);
    const Ink ink = ink_on(background);
    if (ink == Ink::light) out += background_of(background, width, height, scale);
    for (const LineKind kind : kinds) {
        const LineStyle style = line_style(kind, ink);
        out += std::string("  <g id=\"") + style.group + "\" stroke=\"" + hex_color(style.srgb) +
               "\">\n";
        for (const FeatureLine& line : lines)
            if (line.kind == kind) out += path_of(line, width, height, scale);
        out += "  </g>\n";
    }
    return out + "</svg>\n";
}

}  // namespace slim
