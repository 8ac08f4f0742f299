#include "raytrace/font.h"

#include "raytrace/font_glyphs.h"
#include "raytrace/panel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

namespace slim {
namespace {

constexpr float kCapUnits = 14;
constexpr float kGapUnits = 3.1f;

struct Point2 {
    float x, y;
};
struct Segment {
    Point2 a, b;
};

/// The next character of UTF-8 text, which is shortened by it; U+FFFD for a byte that fits nothing.
char32_t next_character(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    const std::size_t n = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : 0;
    if (n == 0 || n > text.size()) {
        text.remove_prefix(1);
        return U'\ufffd';
    }
    char32_t code = n == 1 ? first : n == 2 ? first & 31u : first & 15u;
    for (std::size_t i = 1; i < n; ++i) code = code << 6 | (byte(i) & 63u);
    text.remove_prefix(n);
    return code;
}

/// Where a glyph's origin lies in the picture, and which way it runs from there.
struct GlyphPlace {
    float x, y, scale;
    float cosine = 1, sine = 0;  ///< of the angle to the picture's right, clockwise

    Point2 pixels(const Point2& p) const {
        const float right = p.x * scale, up = p.y * scale;
        return {x + right * cosine + up * sine, y + right * sine - up * cosine};
    }
    void advance(float units) {
        x += units * scale * cosine;
        y += units * scale * sine;
    }
};

/// Turns a glyph's path into line segments in pixels.
class Pen {
public:
    Pen(std::vector<Segment>& out, const GlyphPlace& place) : out_(out), place_(place) {}

    void draw(const Glyph& glyph) {
        draw(glyph.path);
        origin_ = {glyph.mark_x, glyph.mark_y};
        draw(glyph.mark);
    }

private:
    void draw(const char* path) {
        while (*path) {
            const char command = *path++;
            if (command == 'M') at_ = point(path);
            if (command == 'L') line_to(point(path));
            if (command == 'A') arc(path);
        }
    }
    static float number(const char*& path) {
        char* end = nullptr;
        const float value = std::strtof(path, &end);
        path = end;
        while (*path == ' ') ++path;
        return value;
    }
    static Point2 point(const char*& path) {
        const float x = number(path);
        return {x, number(path)};
    }
    void line_to(const Point2& p) {
        out_.push_back({placed(at_), placed(p)});
        at_ = p;
    }
    Point2 placed(const Point2& p) const {
        return place_.pixels({p.x + origin_.x, p.y + origin_.y});
    }
    void arc(const char*& path) {
        const Point2 center = point(path), radius = point(path), angles = point(path);
        const int n = std::max(2, static_cast<int>(std::abs(angles.y - angles.x) / 12));
        for (int i = 0; i <= n; ++i) {
            const float degrees = angles.x + (angles.y - angles.x) * static_cast<float>(i) /
                                                 static_cast<float>(n);
            const float t = degrees * std::numbers::pi_v<float> / 180;
            line_to({center.x + radius.x * std::cos(t), center.y + radius.y * std::sin(t)});
        }
    }

    std::vector<Segment>& out_;
    const GlyphPlace& place_;
    Point2 at_{0, 0}, origin_{0, 0};
};

float distance_to(const Segment& s, float x, float y) {
    const float dx = s.b.x - s.a.x, dy = s.b.y - s.a.y;
    const float sq = dx * dx + dy * dy;
    const float along = sq > 0 ? ((x - s.a.x) * dx + (y - s.a.y) * dy) / sq : 0;
    const float t = std::clamp(along, 0.0f, 1.0f);
    return std::hypot(x - s.a.x - t * dx, y - s.a.y - t * dy);
}

/// The pixels of one glyph, with how much of each the pen covers.
class CoverageBox {
public:
    CoverageBox(const std::vector<Segment>& segments, float pen_radius) {
        float lo_x = 1e9f, lo_y = 1e9f, hi_x = -1e9f, hi_y = -1e9f;
        for (const Segment& s : segments) {
            lo_x = std::min({lo_x, s.a.x, s.b.x}), hi_x = std::max({hi_x, s.a.x, s.b.x});
            lo_y = std::min({lo_y, s.a.y, s.b.y}), hi_y = std::max({hi_y, s.a.y, s.b.y});
        }
        x0_ = static_cast<int>(std::floor(lo_x - pen_radius - 1));
        y0_ = static_cast<int>(std::floor(lo_y - pen_radius - 1));
        width_ = static_cast<int>(std::ceil(hi_x + pen_radius + 1)) - x0_;
        height_ = static_cast<int>(std::ceil(hi_y + pen_radius + 1)) - y0_;
        coverage_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
        for (const Segment& s : segments) add(s, pen_radius);
    }

    void blend(const Canvas& canvas, const Vec3f& color, float opacity = 1) const {
        for (int y = std::max(0, canvas.y0 - y0_); y < std::min(height_, canvas.y_end() - y0_); ++y)
            for (int x = std::max(0, canvas.x0 - x0_); x < std::min(width_, canvas.x_end() - x0_);
                 ++x)
                blend_pixel(canvas.pixel(x0_ + x, y0_ + y), color,
                            opacity * coverage_[index(x, y)]);
    }

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(x);
    }
    void add(const Segment& s, float pen_radius) {
        const float reach = pen_radius + 1;
        const int from_x = static_cast<int>(std::min(s.a.x, s.b.x) - reach) - x0_;
        const int to_x = static_cast<int>(std::max(s.a.x, s.b.x) + reach) - x0_;
        const int from_y = static_cast<int>(std::min(s.a.y, s.b.y) - reach) - y0_;
        const int to_y = static_cast<int>(std::max(s.a.y, s.b.y) + reach) - y0_;
        for (int y = std::max(0, from_y); y <= std::min(height_ - 1, to_y); ++y)
            for (int x = std::max(0, from_x); x <= std::min(width_ - 1, to_x); ++x) {
                const float d = distance_to(s, static_cast<float>(x0_ + x) + 0.5f,
                                            static_cast<float>(y0_ + y) + 0.5f);
                float& c = coverage_[index(x, y)];
                c = std::max(c, std::clamp(pen_radius + 0.5f - d, 0.0f, 1.0f));
            }
    }

    int x0_, y0_, width_, height_;
    std::vector<float> coverage_;
};

float pen_radius(const TextStyle& style) {
    return std::max(0.45f, 0.5f * style.weight * style.cap_height);
}

}  // namespace

std::string without_glyphs(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const std::string_view before = text;
        const char32_t code = next_character(text);
        if (glyph_of(code).code == code && code != U'\ufffd') continue;
        out += code == U'\ufffd' ? std::string_view("\xef\xbf\xbd")
                                 : before.substr(0, before.size() - text.size());
    }
    return out;
}

float text_width(std::string_view text, const TextStyle& style) {
    float units = 0;
    while (!text.empty()) units += glyph_of(next_character(text)).advance + kGapUnits;
    return std::max(0.0f, units - kGapUnits) * style.cap_height / kCapUnits;
}

void draw_text(const Canvas& canvas, std::string_view text, float x, float baseline,
               const TextStyle& style) {
    GlyphPlace place{x, baseline, style.cap_height / kCapUnits};
    std::vector<Segment> segments;
    while (!text.empty()) {
        const Glyph glyph = glyph_of(next_character(text));
        segments.clear();
        Pen(segments, place).draw(glyph);
        if (!segments.empty())
            CoverageBox(segments, pen_radius(style)).blend(canvas, style.color);
        place.advance(glyph.advance + kGapUnits);
    }
}

void draw_turned_text(const Canvas& canvas, std::string_view text, float x, float y,
                      float angle_rad, const TextStyle& style) {
    const float half_width = 0.5f * text_width(text, style), half_cap = 0.5f * style.cap_height;
    const float c = std::cos(angle_rad), s = std::sin(angle_rad);
    GlyphPlace place{x - half_width * c - half_cap * s, y - half_width * s + half_cap * c,
                     style.cap_height / kCapUnits, c, s};
    std::vector<Segment> segments;
    while (!text.empty()) {
        const Glyph glyph = glyph_of(next_character(text));
        Pen(segments, place).draw(glyph);
        place.advance(glyph.advance + kGapUnits);
    }
    if (!segments.empty())
        CoverageBox(segments, pen_radius(style)).blend(canvas, style.color, style.opacity);
}

}  // namespace slim
