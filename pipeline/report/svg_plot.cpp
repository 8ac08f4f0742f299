#include "pipeline/report/svg_plot.h"

#include "slim/base/markup.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr double kWidth = 640, kHeight = 400;
constexpr double kLeft = 74, kTop = 14, kBottom = 52, kRight = 168;
constexpr double kNameAt = 36, kOfLetter = 6.6;  ///< from the frame: the curves'
                                                 ///< names; the width of a letter
constexpr double kEdge = 10;  // between the frame and the curves

constexpr std::array kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                 "#e69f00", "#56b4e9", "#000000", "#7f7f7f"};

/// One axis: value to pixel.
class Axis {
public:
    Axis(bool is_log, double from, double to) : log_(is_log), from_(from), to_(to) {}

    bool has(double v) const { return std::isfinite(v) && (!log_ || v > 0); }
    void extend(double v) {
        if (!has(v)) return;
        lo_ = std::min(lo_, place(v)), hi_ = std::max(hi_, place(v));
    }
    /// Call when all values are known.
    void close() {
        if (!(lo_ <= hi_)) lo_ = 0, hi_ = 1;
        // Less than a third of a decade is hard to read.
        const double least = log_ ? 0.35 : std::max(1e-12, 0.02 * std::abs(hi_));
        if (hi_ - lo_ < least) {
            const double more = (least - (hi_ - lo_)) / 2;
            lo_ -= more, hi_ += more;
        }
    }
    double pixel(double v) const { return pixel_of_place(place(v)); }
    double pixel_of_place(double p) const {
        return from_ + (p - lo_) / (hi_ - lo_) * (to_ - from_);
    }
    double place(double v) const { return log_ ? std::log10(v) : v; }
    bool is_log() const { return log_; }

    struct Tick {
        double value;
        bool labelled;
    };
    std::vector<Tick> ticks() const { return log_ ? log_ticks() : even_ticks(); }
    bool shows(double v) const {
        const double margin = kEdge / std::abs(to_ - from_) * (hi_ - lo_);
        return place(v) >= lo_ - margin && place(v) <= hi_ + margin;
    }

private:
    /// Decades (every n-th is labelled); within less than two decades also 2 and 5.
    std::vector<Tick> log_ticks() const {
        std::vector<Tick> out;
        const double decades = hi_ - lo_;
        const int every = static_cast<int>(std::ceil(decades / 8));
        for (int e = static_cast<int>(std::floor(lo_)) - 1; e <= static_cast<int>(std::ceil(hi_));
             ++e)
            for (int k = 1; k < 10; ++k) {
                const double v = k * std::pow(10.0, e);
                if (!shows(v) || (k > 1 && decades > 4)) continue;
                const bool label = k == 1 ? (every <= 1 || e % every == 0)
                                          : decades < 2 && (k == 2 || k == 5);
                out.push_back({v, label});
            }
        return out;
    }
    std::vector<Tick> even_ticks() const {
        const double raw = (hi_ - lo_) / 5, base = std::pow(10.0, std::floor(std::log10(raw)));
        const double step = base * (raw / base > 5   ? 10
                                    : raw / base > 2 ? 5
                                    : raw / base > 1 ? 2
                                                     : 1);
        std::vector<Tick> out;
        for (double v = std::ceil(lo_ / step) * step; v <= hi_ + 1e-9 * step; v += step)
            out.push_back({std::abs(v) < 1e-9 * step ? 0 : v, true});
        return out;
    }

    bool log_;
    double from_, to_;
    double lo_ = std::numeric_limits<double>::infinity(), hi_ = -lo_;
};

std::string tick_text(double v) {
    const double size = std::abs(v);
    return size != 0 && (size < 1e-3 || size >= 1e5) ? fmt::format("{:.3g}", v)
                                                     : fmt::format("{:.6g}", v);
}

std::string line(double x0, double y0, double x1, double y1, const char* style) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>", x0, y0,
                       x1, y1, style);
}

std::string label(double x, double y, const char* anchor, const std::string& text,
                  const char* more = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>", x, y,
                       anchor, more, escaped_markup(text));
}

/// The mark of curve i: circle, square, diamond or triangle.
std::string mark(double x, double y, std::size_t i) {
    switch (i % 4) {
        case 0: return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.4\"/>", x, y);
        case 1:
            return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"6\" height=\"6\"/>", x - 3,
                               y - 3);
        case 2:
            return fmt::format("<path d=\"M{:.1f} {:.1f}l4.4 4.4l-4.4 4.4l-4.4-4.4z\"/>", x,
                               y - 4.4);
        default: return fmt::format("<path d=\"M{:.1f} {:.1f}l4.2 7h-8.4z\"/>", x, y - 4.4);
    }
}

std::string cross(double x, double y) {
    return fmt::format(
        "<path class=\"broken\" d=\"M{:.1f} {:.1f}l9 9m0-9l-9 9\" fill=\"none\" "
        "stroke-width=\"2.2\"/>",
        x - 4.5, y - 4.5);
}

std::string frame_of(const SvgPlot& plot, const Axis& x, const Axis& y) {
    const double right = kWidth - kRight, bottom = kHeight - kBottom;
    std::string out = "<g stroke=\"#ddd\">";
    std::string labels;
    for (const auto& [v, labelled] : x.ticks()) {
        out += line(x.pixel(v), kTop, x.pixel(v), bottom, labelled ? "" : "stroke=\"#f0f0f0\"");
        if (labelled) labels += label(x.pixel(v), bottom + 16, "middle", tick_text(v));
    }
    for (const auto& [v, labelled] : y.ticks()) {
        out += line(kLeft, y.pixel(v), right, y.pixel(v), labelled ? "" : "stroke=\"#f0f0f0\"");
        if (labelled) labels += label(kLeft - 6, y.pixel(v) + 4, "end", tick_text(v));
    }
    out += fmt::format(
        "</g><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#888\"/>",
        kLeft, kTop, right - kLeft, bottom - kTop);
    out += "<g fill=\"#333\">" + labels +
           label((kLeft + right) / 2, kHeight - 12, "middle", plot.x_label);
    return out +
           label(0, 0, "middle", plot.y_label,
                 fmt::format(" transform=\"translate(14 {:.1f}) rotate(-90)\"", (kTop + bottom) / 2)
                     .c_str()) +
           "</g>";
}

/// Dashed, through the middle of the curve, as far as the curve goes and the frame shows.
std::string guide_of(const SvgCurve& curve, const std::vector<SvgCurve::Point>& points,
                     const Axis& x, const Axis& y) {
    if (!curve.has_guide || points.size() < 2 || !x.is_log() || !y.is_log()) return "";
    double mx = 0, my = 0;
    for (const auto& p : points) mx += x.place(p.x), my += y.place(p.y);
    mx /= static_cast<double>(points.size()), my /= static_cast<double>(points.size());
    const auto [least, most] = std::minmax_element(
        points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
    const double x0 = x.place(least->x), x1 = x.place(most->x);
    return line(x.pixel_of_place(x0), y.pixel_of_place(my + curve.guide_slope * (x0 - mx)),
                x.pixel_of_place(x1), y.pixel_of_place(my + curve.guide_slope * (x1 - mx)),
                "stroke-dasharray=\"5 4\" stroke-width=\"1\" opacity=\"0.7\" "
                "clip-path=\"url(#plot-area)\"");
}

std::string curve_of(const SvgCurve& curve, std::size_t i, const Axis& x, const Axis& y) {
    std::vector<SvgCurve::Point> points;
    for (const auto& p : curve.points)
        if (x.has(p.x) && y.has(p.y)) points.push_back(p);
    const char* colour = kColours[i % kColours.size()];
    std::string path, marks;
    for (const auto& p : points) {
        path +=
            fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x.pixel(p.x), y.pixel(p.y));
        marks += p.broken ? cross(x.pixel(p.x), y.pixel(p.y)) : mark(x.pixel(p.x), y.pixel(p.y), i);
    }
    const double ly = kTop + 12 + 17 * static_cast<double>(i), lx = kWidth - kRight + 14;
    std::string out = fmt::format("<g class=\"curve\" stroke=\"{0}\" fill=\"{0}\">", colour);
    if (!path.empty())
        out += fmt::format("<path d=\"{}\" fill=\"none\" stroke-width=\"1.6\"/>", path);
    out += guide_of(curve, points, x, y) + marks +
           line(lx, ly, lx + 16, ly, "stroke-width=\"1.6\"") + mark(lx + 8, ly, i) + "</g>";
    return out + "<g fill=\"#333\">" +
           label(kWidth - kRight + kNameAt, ly + 4, "start", curve.name) + "</g>";
}

}  // namespace

std::string svg_of(const SvgPlot& plot) {
    double width = kWidth;
    for (const SvgCurve& curve : plot.curves)
        width = std::max(
            width, kWidth - kRight + kNameAt + kOfLetter * static_cast<double>(curve.name.size()));
    Axis x(plot.log_x, kLeft + kEdge, kWidth - kRight - kEdge);
    Axis y(plot.log_y, kHeight - kBottom - kEdge, kTop + kEdge);
    for (const SvgCurve& curve : plot.curves)
        for (const auto& p : curve.points)
            if (x.has(p.x) && y.has(p.y)) x.extend(p.x), y.extend(p.y);
    x.close(), y.close();
    std::string out = fmt::format(
        "<svg class=\"plot\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" "
        "font-family=\"system-ui, sans-serif\" font-size=\"12\"><defs><clipPath "
        "id=\"plot-area\"><rect x=\"{2}\" y=\"{3}\" width=\"{4}\" "
        "height=\"{5}\"/></clipPath></defs>",
        width, kHeight, kLeft, kTop, kWidth - kRight - kLeft, kHeight - kBottom - kTop);
    out += frame_of(plot, x, y);
    for (std::size_t i = 0; i < plot.curves.size(); ++i) out += curve_of(plot.curves[i], i, x, y);
    return out + "</svg>\n";
}

}  // namespace slim
