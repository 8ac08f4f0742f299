#include "raytrace/lines/height_svg.h"

#include "raytrace/picture.h"
#include "raytrace/svg_color.h"
#include "slim/base/markup.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr float kThinned = 1.0f / 6;   ///< pixels
constexpr float kShortest = 4;         ///< in widths of a line
constexpr double kCapHeight = 0.73;    ///< of a sans-serif's size

using Points = std::vector<PicturePoint>;

/// How far a point lies off the segment's line, pixels.
float distance_from(const PicturePoint& p, const PicturePoint& a, const PicturePoint& b) {
    const float dx = b.x - a.x, dy = b.y - a.y, chord = std::hypot(dx, dy);
    if (!(chord > 0)) return std::hypot(p.x - a.x, p.y - a.y);
    return std::abs((p.x - a.x) * dy - (p.y - a.y) * dx) / chord;
}

/// Douglas and Peucker 1973.
Points thinned(const Points& points) {
    if (points.size() < 3) return points;
    std::vector<char> kept(points.size(), 0);
    kept.front() = kept.back() = 1;
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, points.size() - 1}};
    while (!open.empty()) {
        const auto [from, to] = open.back();
        open.pop_back();
        std::size_t farthest = from;
        float most = kThinned;
        for (std::size_t i = from + 1; i < to; ++i)
            if (const float d = distance_from(points[i], points[from], points[to]); d > most)
                most = d, farthest = i;
        if (farthest == from) continue;
        kept[farthest] = 1;
        open.push_back({from, farthest}), open.push_back({farthest, to});
    }
    Points out;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (kept[i]) out.push_back(points[i]);
    return out;
}

bool in_gap(const PicturePoint& p, std::span<const HeightLabel> labels) {
    return std::any_of(labels.begin(), labels.end(), [&](const HeightLabel& label) {
        return seen_beside(label, p.x, p.y) < 0.5f;
    });
}

/// The pieces that the gaps leave of a line, whose points lie about a pixel apart. A closed one
/// begins behind a gap.
std::vector<Points> pieces_of(const HeightLine& line, std::span<const HeightLabel> labels) {
    Points points = line.points;
    if (line.closed) {
        const auto gap = std::find_if(points.begin(), points.end(), [&](const PicturePoint& p) {
            return in_gap(p, labels);
        });
        if (gap != points.end()) std::rotate(points.begin(), gap, points.end());
        points.push_back(points.front());
    }
    std::vector<Points> pieces(1);
    for (const PicturePoint& p : points) {
        if (!in_gap(p, labels))
            pieces.back().push_back(p);
        else if (!pieces.back().empty())
            pieces.emplace_back();
    }
    return pieces;
}

float length_of(const Points& points) {
    float length = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        length += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
    return length;
}

std::string place(const PicturePoint& p, const SvgScale& scale) {
    return scale.mm(p.x) + "," + scale.mm(p.y);
}

void write_line(const HeightLine& line, std::span<const HeightLabel> labels, float shortest,
                const SvgScale& scale, std::string& out) {
    for (const Points& piece : pieces_of(line, labels)) {
        if (piece.size() < 2 || length_of(piece) < shortest) continue;
        const char* before = "    <path d=\"M";
        for (const PicturePoint& p : thinned(piece)) out += before + place(p, scale), before = " ";
        out += "\"/>\n";
    }
}

void write_lines(std::span<const HeightLine> lines, std::span<const HeightLabel> labels,
                 const std::string& group, int index_every, bool index, float width,
                 float shortest, const SvgScale& scale, std::string& out) {
    const Vec3f ink{srgb_from_linear(kContourInk.x), srgb_from_linear(kContourInk.y),
                    srgb_from_linear(kContourInk.z)};
    out += "  <g id=\"" + group + "\" stroke=\"" + hex_color(ink) + "\" stroke-width=\"" +
           scale.mm(width) + "\">\n";
    for (const HeightLine& line : lines)
        if ((line.level % index_every == 0) == index)
            write_line(line, labels, shortest, scale, out);
    out += "  </g>\n";
}

void write_label(const HeightLabel& label, const SvgScale& scale, std::string& out) {
    const double cap = static_cast<double>(label.cap_height);
    out += "    <text transform=\"translate(" + place({label.x, label.y}, scale) + ") rotate(" +
           svg_number(static_cast<double>(label.angle_rad) * 180 / std::numbers::pi, 2) +
           ")\" y=\"" +
           scale.mm(cap / 2) + "\" font-size=\"" + scale.mm(cap / kCapHeight) + "\">" +
           escaped_markup(label.text) + "</text>\n";
}

}  // namespace

std::string height_svg(std::span<const HeightLine> lines, std::span<const HeightLabel> labels,
                       int index_every, float line_width, const PixelWindow& window,
                       const SvgScale& scale) {
    constexpr float kThin = 0.7f;  // as pale as paint_relief's
    std::string out = scale.opening(window);
    write_lines(lines, labels, "contour-lines", index_every, false, kThin * line_width,
                kShortest * line_width, scale, out);
    write_lines(lines, labels, "index-contours", index_every, true, 2 * line_width,
                kShortest * line_width, scale, out);
    const Vec3f ink{srgb_from_linear(kContourInk.x), srgb_from_linear(kContourInk.y),
                    srgb_from_linear(kContourInk.z)};
    out += "  <g id=\"contour-heights\" fill=\"" + hex_color(ink) +
           "\" stroke=\"none\" text-anchor=\"middle\" "
           "font-family=\"Helvetica, Arial, sans-serif\">\n";
    for (const HeightLabel& label : labels) write_label(label, scale, out);
    return out + "  </g>\n</svg>\n";
}

}  // namespace slim
