#include "raytrace/lines/stroke.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kBandRows = 64;

/// Rows [begin, end) of a picture with the coverage of one line.
struct Band {
    int width, begin, end;
    std::vector<float> coverage;
    int x0, x1, y0, y1;  ///< what was touched

    void start() { x0 = width, x1 = 0, y0 = end, y1 = begin; }
    float& at(int x, int y) {
        return coverage[static_cast<std::size_t>(y - begin) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x)];
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
    const int x0 = std::max(0, low(a.x, b.x)), x1 = std::min(band.width, high(a.x, b.x));
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

/// Lays a line's colour over what it covers, and clears the coverage.
void composite(const Vec3f& srgb, Band& band, Picture& picture) {
    const Vec3f color{linear_from_srgb(srgb.x), linear_from_srgb(srgb.y), linear_from_srgb(srgb.z)};
    for (int y = band.y0; y < band.y1; ++y)
        for (int x = band.x0; x < band.x1; ++x) {
            float& c = band.at(x, y);
            if (c == 0) continue;
            float* p = picture.pixel(x, y);
            for (std::size_t i = 0; i < 3; ++i) p[i] = p[i] * (1 - c) + color[i] * c;
            p[3] = p[3] * (1 - c) + c;
            c = 0;
        }
}

/// Rows that a line may touch.
struct RowSpan {
    float top = INFINITY, bottom = -INFINITY;
};
RowSpan rows_of(const FeatureLine& line) {
    RowSpan rows;
    for (const LinePoint& p : line.points)
        rows.top = std::min(rows.top, p.y), rows.bottom = std::max(rows.bottom, p.y);
    return rows;
}

}  // namespace

LineStyle line_style(LineKind kind) {
    switch (kind) {
        case LineKind::contour:
            return {{0.06f, 0.06f, 0.07f}, "contour"};
        case LineKind::suggestive:
            return {{0.06f, 0.06f, 0.07f}, "suggestive"};
        case LineKind::ridge:
            return {{0.66f, 0.08f, 0.07f}, "crest-ridge"};  // as convex in the curvature maps
        case LineKind::valley:
            return {{0.05f, 0.20f, 0.62f}, "crest-valley"};
        case LineKind::parabolic:
            return {{0.05f, 0.40f, 0.22f}, "parabolic"};
        case LineKind::convex_crease:
            return {{0.36f, 0.05f, 0.05f}, "crease-convex"};  // darker than ridges and ravines
        case LineKind::concave_crease:
            return {{0.03f, 0.12f, 0.36f}, "crease-concave"};
        case LineKind::reflection:
            break;
    }
    return {{0.20f, 0.20f, 0.24f}, "reflection"};
}

float stroke_width(const FeatureLine& line, int picture_width, int picture_height) {
    const float scale =
        std::max(0.6f, static_cast<float>(std::min(picture_width, picture_height)) / 1000);
    if (line.kind == LineKind::contour) return 1.8f * scale;
    if (line.kind == LineKind::reflection) return 1.0f * scale;
    if (is_crease(line.kind)) return std::clamp(0.6f + line.strength / 75, 0.6f, 1.8f) * scale;
    return std::clamp(0.9f + 0.25f * std::log2(std::max(line.strength, 0.1f)), 0.6f, 2.2f) * scale;
}

void draw_lines(std::span<const FeatureLine> lines, Picture& picture) {
    std::vector<RowSpan> rows;
    for (const FeatureLine& line : lines) rows.push_back(rows_of(line));
    const auto height = static_cast<std::size_t>(picture.height);
    parallel_blocks(height, kBandRows, [&](std::size_t begin, std::size_t end) {
        Band band{picture.width, static_cast<int>(begin), static_cast<int>(end), {}, 0, 0, 0, 0};
        band.coverage.assign((end - begin) * static_cast<std::size_t>(picture.width), 0.0f);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const float half = 0.5f * stroke_width(lines[i], picture.width, picture.height);
            if (rows[i].bottom + half + 1 < static_cast<float>(begin) ||
                rows[i].top - half - 1 > static_cast<float>(end))
                continue;
            band.start();
            lines[i].for_each_segment(
                [&](const LinePoint& a, const LinePoint& b) { cover_segment(a, b, half, band); });
            composite(line_style(lines[i].kind).srgb, band, picture);
        }
    });
}

std::vector<float> strength_plane(std::span<const FeatureLine> lines,
                                  std::span<const LineKind> kinds, int width, int height) {
    std::vector<float> plane(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                             0.0f);
    const auto mark = [&](float x, float y, float strength) {
        const int px = std::clamp(static_cast<int>(x), 0, width - 1);
        const int py = std::clamp(static_cast<int>(y), 0, height - 1);
        float& v = plane[static_cast<std::size_t>(py) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(px)];
        v = std::max(v, strength);
    };
    for (const FeatureLine& line : lines) {
        if (std::find(kinds.begin(), kinds.end(), line.kind) == kinds.end()) continue;
        for (const LinePoint& p : line.points) mark(p.x, p.y, line.strength);
    }
    return plane;
}

}  // namespace slim
