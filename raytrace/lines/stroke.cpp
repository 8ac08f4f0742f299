#include "raytrace/lines/stroke.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kBandRows = 64;
constexpr float kFlare = 0.05f;  ///< light that a screen adds to every colour (WCAG 2)

/// Of linear Rec.709.
float luminance(const Vec3f& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

/// Columns [left, right) of rows [begin, end) of a picture with the coverage of one line.
struct Band {
    int left, right, begin, end;
    std::vector<float> coverage;
    int x0, x1, y0, y1;  ///< what was touched

    Band(int a_left, int a_right, int a_begin, int an_end)
        : left(a_left),
          right(a_right),
          begin(a_begin),
          end(an_end),
          coverage(index(left, end), 0.0f) {}

    void start() { x0 = right, x1 = left, y0 = end, y1 = begin; }
    float& at(int x, int y) { return coverage[index(x, y)]; }

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y - begin) * static_cast<std::size_t>(right - left) +
               static_cast<std::size_t>(x - left);
    }
};

/// Distance of a pixel's centre from a segment.
float distance_to(float px, float py, const LinePoint& a, const LinePoint& b) {
    const float dx = b.x - a.x, dy = b.y - a.y, sq = dx * dx + dy * dy;
    const float t = sq > 0 ? std::clamp(((px - a.x) * dx + (py - a.y) * dy) / sq, 0.0f, 1.0f) : 0;
    return std::hypot(px - a.x - t * dx, py - a.y - t * dy);
}

void cover_segment(const LinePoint& a, const LinePoint& b, float half, Band& band) {
    const float reach = half + 0.5f;
    const auto low = [&](float p, float q) {
        return static_cast<int>(std::floor(std::min(p, q) - reach));
    };
    const auto high = [&](float p, float q) {
        return static_cast<int>(std::ceil(std::max(p, q) + reach));
    };
    const int x0 = std::max(band.left, low(a.x, b.x)), x1 = std::min(band.right, high(a.x, b.x));
    const int y0 = std::max(band.begin, low(a.y, b.y)), y1 = std::min(band.end, high(a.y, b.y));
    // A stroke thinner than a pixel is as pale as it is thin.
    const float most = std::min(1.0f, 2 * half);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            const float d =
                distance_to(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, a, b);
            float& c = band.at(x, y);
            c = std::max(c, std::clamp(std::max(half, 0.5f) + 0.5f - d, 0.0f, 1.0f) * most);
        }
    if (x0 >= x1 || y0 >= y1) return;
    band.x0 = std::min(band.x0, x0), band.x1 = std::max(band.x1, x1);
    band.y0 = std::min(band.y0, y0), band.y1 = std::max(band.y1, y1);
}

Vec3f linear_ink(LineKind kind, Ink ink) {
    const Vec3f& srgb = line_style(kind, ink).srgb;
    return {linear_from_srgb(srgb.x), linear_from_srgb(srgb.y), linear_from_srgb(srgb.z)};
}

/// Lays a line's colour over what it covers, and clears the coverage.
void composite(LineKind kind, const LineInks& inks, Band& band, const Canvas& canvas) {
    const Vec3f own = linear_ink(kind, inks.ink);
    const Vec3f other = linear_ink(kind, inks.ink == Ink::dark ? Ink::light : Ink::dark);
    for (int y = band.y0; y < band.y1; ++y)
        for (int x = band.x0; x < band.x1; ++x) {
            float& c = band.at(x, y);
            if (c == 0) continue;
            const std::size_t i = canvas.part.index(x - canvas.x0, y - canvas.y0);
            const float share = inks.other.empty() ? 0 : inks.other[i];
            const Vec3f color = own + (other - own) * share;
            float* p = canvas.pixel(x, y);
            for (std::size_t k = 0; k < 3; ++k) p[k] = p[k] * (1 - c) + color[k] * c;
            p[3] = p[3] * (1 - c) + c;
            c = 0;
        }
}

/// What a line's stroke may touch.
struct StrokeBox {
    float left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;

    StrokeBox(const FeatureLine& line, int picture_width, int picture_height) {
        for (const LinePoint& p : line.points) {
            left = std::min(left, p.x), right = std::max(right, p.x);
            top = std::min(top, p.y), bottom = std::max(bottom, p.y);
        }
        const float reach = 0.5f * stroke_width(line, picture_width, picture_height) + 1;
        left -= reach, right += reach, top -= reach, bottom += reach;
    }
    bool meets(const PixelWindow& w) const {
        return right >= static_cast<float>(w.x) && left <= static_cast<float>(w.x + w.width) &&
               bottom >= static_cast<float>(w.y) && top <= static_cast<float>(w.y + w.height);
    }
};

std::vector<StrokeBox> boxes_of(std::span<const FeatureLine> lines, int picture_width,
                                int picture_height) {
    std::vector<StrokeBox> boxes;
    for (const FeatureLine& line : lines) boxes.emplace_back(line, picture_width, picture_height);
    return boxes;
}

}  // namespace

Ink ink_on(const Background& background) {
    if (!(background.alpha > 0)) return Ink::dark;
    const auto contrast = [&](Ink ink) {
        const float own = luminance(linear_ink(LineKind::contour, ink));
        const auto with = [own](const Vec3f& linear) {
            const float other = luminance(linear);
            return (std::max(own, other) + kFlare) / (std::min(own, other) + kFlare);
        };
        return std::min(with(background.top), with(background.bottom));
    };
    return contrast(Ink::light) > contrast(Ink::dark) ? Ink::light : Ink::dark;
}

LineStyle line_style(LineKind kind, Ink ink) {
    const auto style = [ink](const Vec3f& dark, const Vec3f& light, const char* group) {
        return LineStyle{ink == Ink::dark ? dark : light, group};
    };
    switch (kind) {
        case LineKind::contour:
            return style({0.06f, 0.06f, 0.07f}, {0.95f, 0.95f, 0.94f}, "contour");
        case LineKind::suggestive:
            return style({0.06f, 0.06f, 0.07f}, {0.95f, 0.95f, 0.94f}, "suggestive");
        case LineKind::ridge:  // as convex in the curvature maps
            return style({0.66f, 0.08f, 0.07f}, {1.0f, 0.52f, 0.47f}, "crest-ridge");
        case LineKind::valley:
            return style({0.05f, 0.20f, 0.62f}, {0.50f, 0.68f, 1.0f}, "crest-valley");
        case LineKind::parabolic:
            return style({0.05f, 0.40f, 0.22f}, {0.45f, 0.85f, 0.60f}, "parabolic");
        case LineKind::convex_crease:  // darker, or lighter, than ridges and ravines
            return style({0.36f, 0.05f, 0.05f}, {1.0f, 0.76f, 0.72f}, "crease-convex");
        case LineKind::concave_crease:
            return style({0.03f, 0.12f, 0.36f}, {0.74f, 0.84f, 1.0f}, "crease-concave");
        case LineKind::reflection:
            break;
    }
    return style({0.20f, 0.20f, 0.24f}, {0.78f, 0.78f, 0.76f}, "reflection");
}

float stroke_width(const FeatureLine& line, int picture_width, int picture_height) {
    const float scale =
        std::max(0.6f, static_cast<float>(std::min(picture_width, picture_height)) / 1000);
    if (line.kind == LineKind::contour) return 1.8f * scale;
    if (line.kind == LineKind::reflection) return 1.0f * scale;
    if (is_crease(line.kind)) return std::clamp(0.6f + line.strength / 75, 0.6f, 1.8f) * scale;
    return std::clamp(0.9f + 0.25f * std::log2(std::max(line.strength, 0.1f)), 0.6f, 2.2f) * scale;
}

void draw_lines(std::span<const FeatureLine> lines, const Canvas& canvas,
                const LineInks& inks) {
    SLIM_CHECK(inks.other.empty() || inks.other.size() == canvas.part.n_pixels(), ==, true);
    const std::vector<StrokeBox> boxes = boxes_of(lines, canvas.width, canvas.height);
    const auto n_rows = static_cast<std::size_t>(canvas.part.height);
    parallel_blocks(n_rows, kBandRows, [&](std::size_t first, std::size_t last) {
        const int begin = canvas.y0 + static_cast<int>(first),
                  end = canvas.y0 + static_cast<int>(last);
        const PixelWindow window{canvas.x0, begin, canvas.part.width, end - begin};
        Band band(canvas.x0, canvas.x_end(), begin, end);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            if (!boxes[i].meets(window)) continue;
            const float half = 0.5f * stroke_width(lines[i], canvas.width, canvas.height);
            band.start();
            lines[i].for_each_segment(
                [&](const LinePoint& a, const LinePoint& b) { cover_segment(a, b, half, band); });
            composite(lines[i].kind, inks, band, canvas);
        }
    });
}

std::vector<float> strength_plane(std::span<const FeatureLine> lines,
                                  std::span<const LineKind> kinds, int width, int height,
                                  const PixelWindow& w) {
    std::vector<float> plane(static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height),
                             0.0f);
    const auto mark = [&](float x, float y, float strength) {
        const int px = std::clamp(static_cast<int>(x), 0, width - 1) - w.x;
        const int py = std::clamp(static_cast<int>(y), 0, height - 1) - w.y;
        if (px < 0 || py < 0 || px >= w.width || py >= w.height) return;
        float& v = plane[static_cast<std::size_t>(py) * static_cast<std::size_t>(w.width) +
                         static_cast<std::size_t>(px)];
        v = std::max(v, strength);
    };
    for (const FeatureLine& line : lines) {
        if (std::find(kinds.begin(), kinds.end(), line.kind) == kinds.end()) continue;
        for (const LinePoint& p : line.points) mark(p.x, p.y, line.strength);
    }
    return plane;
}

std::vector<FeatureLine> lines_within(std::span<const FeatureLine> lines, int width, int height,
                                      const PixelWindow& window) {
    std::vector<FeatureLine> within;
    for (const FeatureLine& line : lines)
        if (StrokeBox(line, width, height).meets(window)) within.push_back(line);
    return within;
}

}  // namespace slim
