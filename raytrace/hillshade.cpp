#include "raytrace/hillshade.h"

#include "slim/base/angle.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace slim {
namespace {

constexpr Vec3f kShadow{0.035f, 0.045f, 0.070f}, kLit{0.86f, 0.84f, 0.79f};

Vec3f toward_sun(const Relief& r) {
    const double a = radians(r.azimuth_deg), h = radians(r.altitude_deg);
    const auto east = static_cast<float>(std::sin(a) * std::cos(h));
    const auto south = static_cast<float>(-std::cos(a) * std::cos(h));
    return r.axes[0] * east + r.axes[1] * static_cast<float>(std::sin(h)) + r.axes[2] * south;
}

/// Light on a slope: a level plane is a light grey, slopes away from the sun go to blue. In its
/// shade the light goes on falling, so that the far side of what stands upright keeps its shape: t
/// / (1 - t' / t c) with t and t' of cosine 0.
Vec3f relief_color(float cosine) {
    constexpr float kAmbient = 0.18f, kPower = 1.15f;
    constexpr float kAtTerminator = 0.13918f;  // kAmbient^kPower
    constexpr float kFall = kPower * (1 - kAmbient) / kAmbient;  // t' / t
    const float t = cosine >= 0
                        ? std::pow(std::min(kAmbient + (1 - kAmbient) * cosine, 1.0f), kPower)
                        : kAtTerminator / (1 - kFall * cosine);
    return kShadow * (1 - t) + kLit * t;
}

/// How far the surface rises and falls about a pixel to either side, and on both on average; model
/// units a pixel, >= 0.
struct Slopes {
    float rise, fall, mean;
};

/// Slopes of the heights themselves: the differences to the pixels beside it. (A blended normal is
/// not the slope of the blended heights where surfels change.) What rises to either side counts, so
/// that of two pixels with a height between theirs the one's way to it and the other's are together
/// one pixel at most: no line has gaps.
class HeightSlopes {
public:
    HeightSlopes(const GBuffer& b, const PixelView& v, const ShadeView& shade, const Vec3f& up)
        : b_(b), view_(v), shade_(shade), up_(up) {
        const double per_px = v.orthographic ? 1 / v.px_per_unit : 1 / v.focal_px;
        step_x_ = to_float(v.right * per_px), step_y_ = to_float(v.down * per_px);
        forward_ = to_float(v.forward), eye_ = to_float(v.eye);
    }

    /// At a hit.
    Slopes at(int x, int y) const {
        const Spot here = spot(x, y);
        const Slopes across = axis(here, x, shade_.first_x, b_.width, step_x_,
                                   [&](int other) { return b_.index(other, y); });
        const Slopes down = axis(here, y, shade_.first_y, b_.height, step_y_,
                                 [&](int other) { return b_.index(x, other); });
        return {std::hypot(across.rise, down.rise), std::hypot(across.fall, down.fall),
                std::hypot(across.mean, down.mean)};
    }

private:
    /// A pixel's surface; `ray` is one unit deep.
    struct Spot {
        Vec3f p, n, ray;
        float depth, facing;
    };

    Spot spot(int x, int y) const { return spot(b_.index(x, y)); }
    Spot spot(std::size_t i) const {
        Spot s;
        s.p = {b_.position[0][i], b_.position[1][i], b_.position[2][i]};
        s.n = {b_.normal[0][i], b_.normal[1][i], b_.normal[2][i]};
        const Vec3f from_eye = s.p - eye_;
        s.depth = view_.orthographic ? 1 : dot(from_eye, forward_);
        s.ray = view_.orthographic ? forward_ : from_eye / s.depth;
        s.facing = dot(s.n, s.ray);
        return s;
    }

    /// Change of height to the next pixel of the tangent plane.
    float on_tangent(const Spot& s, const Vec3f& step_at_1) const {
        if (std::abs(s.facing) < 1e-6f) return 1e30f;
        const Vec3f step = step_at_1 * s.depth;
        return dot(up_, step - s.ray * (dot(s.n, step) / s.facing));
    }

    /// Whether two pixels beside each other show one surface: it leaves the view's plane by no more
    /// than the steeper of their tangent planes and as much as 45 degrees.
    bool is_one_surface(const Spot& a, const Spot& b) const {
        const float length_of_ray = length(a.ray);
        const Vec3f way = b.p - a.p, toward = a.ray / length_of_ray;
        const float deep = dot(way, toward), aside = length(way - toward * deep);
        const float facing = std::min(std::abs(a.facing), std::abs(b.facing)) / length_of_ray;
        return std::abs(deep) * facing <= aside * (1 + facing);
    }

    /// Change of height to a pixel; none if that shows another surface or nothing. Of a picture's
    /// samples only those of one pixel are sure to be there.
    template <class IndexOf>
    std::optional<float> change_to(const Spot& here, int at, int other, int first, int size,
                                   IndexOf&& index_of) const {
        const bool is_in = other >= 0 && other < size;
        if (!is_in || (shade_.around && (at + first) / 2 != (other + first) / 2)) return {};
        const std::size_t i = index_of(other);
        if (!b_.hit[i]) return {};
        const Spot there = spot(i);
        if (!is_one_surface(here, there)) return {};
        return dot(up_, there.p - here.p);
    }

    template <class IndexOf>
    Slopes axis(const Spot& here, int at, int first, int size, const Vec3f& step,
                IndexOf&& index_of) const {
        std::optional<float> before = change_to(here, at, at - 1, first, size, index_of);
        std::optional<float> after = change_to(here, at, at + 1, first, size, index_of);
        if (!before && !after) after = on_tangent(here, step);
        if (!before) before = -*after;
        if (!after) after = -*before;
        return {std::max({*before, *after, 0.0f}), std::max({-*before, -*after, 0.0f}),
                std::abs(*after - *before) / 2};
    }

    const GBuffer& b_;
    const PixelView& view_;
    const ShadeView& shade_;
    Vec3f up_, step_x_, step_y_, forward_, eye_;
};

/// How much of a pixel a line covers whose middle is `distance` pixels away; lines lie `gap` pixels
/// apart.
float line_cover(float distance, float width, float gap) {
    const float cover = std::clamp(width / 2 + 0.5f - distance, 0.0f, 1.0f);
    // Below three widths they run into a tone: the share of the ground that they take, at most a
    // half.
    const float tone = std::min(0.5f, width / std::max(gap, 1e-6f));
    const float t = std::clamp(gap / (1.5f * (width + 1)) - 1, 0.0f, 1.0f);
    return tone * (1 - t) + cover * t;
}

/// Cover of the contour lines next to a height. Index lines fade by their own distance: they stay
/// where the lines between run into a tone.
float contour_cover(const Relief& r, double height, const Slopes& slopes, float width) {
    constexpr double kMostSteps = 1e15;  // beyond, a double no longer tells a line from the next
    constexpr float kThin = 0.7f;
    if (!(std::abs(height / r.spacing) < kMostSteps)) return kThin * line_cover(0, width, 0);
    const auto cover_of = [&](double spacing, float line_width) {
        const double in_steps = height / spacing, line = std::round(in_steps);
        const auto in_pixels = [&](float slope) {
            return std::min(
                static_cast<float>(std::min(spacing, 1e30)) / std::max(slope, 1e-30f), 1e30f);
        };
        const float toward = line > in_steps ? slopes.rise : slopes.fall;
        return line_cover(static_cast<float>(std::abs(in_steps - line)) * in_pixels(toward),
                          line_width, in_pixels(slopes.mean));
    };
    return std::max(kThin * cover_of(r.spacing, width),
                    cover_of(r.spacing * r.index_every, 2 * width));
}

/// What the labels of a row of the frame leave of the lines at its pixels.
class RowOfGaps {
public:
    RowOfGaps(std::span<const HeightLabel> labels, const ShadeView& shade, int y, int factor)
        : first_x_(shade.first_x),
          to_picture_(1 / static_cast<float>(factor)),
          y_((static_cast<float>(y + shade.first_y) + 0.5f) * to_picture_),
          near_(labels_near(labels, y_)) {}

    float at(int x) const {
        float seen = 1;
        const float px = (static_cast<float>(x + first_x_) + 0.5f) * to_picture_;
        for (const HeightLabel* label : near_) seen = std::min(seen, seen_beside(*label, px, y_));
        return seen;
    }

private:
    int first_x_;
    float to_picture_, y_;
    std::vector<const HeightLabel*> near_;
};

}  // namespace

double contour_spacing(double low, double high) {
    const double wanted = (high - low) / 20;
    if (!(wanted > 0) || !std::isfinite(wanted)) return 0;
    const double power = std::pow(10.0, std::floor(std::log10(wanted)));
    const double digit = wanted / power;
    return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

namespace {

/// Multiples of a step in [low, high].
std::int64_t n_multiples(double step, double low, double high) {
    if (!std::isfinite(step)) return low <= 0 && high >= 0 ? 1 : 0;
    const double n = std::floor(high / step) - std::ceil(low / step) + 1;
    return static_cast<std::int64_t>(std::clamp(n, 0.0, 1e15));
}

}  // namespace

ContourLevels contour_levels(const Relief& r, double low, double high) {
    if (!(r.spacing > 0)) return {0, 0, low, high, 0, 0};
    const double heavy = r.spacing * r.index_every;
    return {r.spacing, heavy, low, high, n_multiples(r.spacing, low, high),
            n_multiples(heavy, low, high)};
}

std::array<double, 2> height_span(const GBuffer& frame, const Relief& relief, double percent) {
    std::vector<float> heights;
    for (std::size_t i = 0; i < frame.n_pixels(); ++i)
        if (frame.hit[i])
            heights.push_back(dot(relief.axes[1], Vec3f{frame.position[0][i], frame.position[1][i],
                                                        frame.position[2][i]}));
    if (heights.empty()) return {relief.base, relief.base};
    const auto rank = [&](double share) {
        const auto k =
            static_cast<std::ptrdiff_t>(share / 100 * static_cast<double>(heights.size() - 1));
        std::nth_element(heights.begin(), heights.begin() + k, heights.end());
        return relief.base + static_cast<double>(heights[static_cast<std::size_t>(k)]);
    };
    const double low = rank(percent);
    return {low, rank(100 - percent)};
}

Picture paint_relief(const GBuffer& b, const PixelView& view, const ShadeView& shade,
                     const RowRange& rows, const Relief& relief, float line_width,
                     std::span<const HeightLabel> labels, int factor) {
    Picture out(b.width, rows.end - rows.begin);
    const Vec3f sun = toward_sun(relief);
    const HeightSlopes slopes(b, view, shade, relief.axes[1]);
    const Vec3f right = to_float(shade.right), up = to_float(shade.up), back = to_float(shade.back);
    for_eye_rows(
        b.width, b.height, rows, shade, {b.normal[0], b.normal[1], b.normal[2]}, b.hit,
        [&](const EyeRow& row) {
            const RowOfGaps gaps(labels, shade, row.y, factor);
            for (int x = 0; x < b.width; ++x) {
                const auto k = static_cast<std::size_t>(x);
                if (!row.hit[k]) continue;
                const Vec3f n =
                    right * row.normal[k].x + up * row.normal[k].y + back * row.normal[k].z;
                Vec3f color = relief_color(dot(n, sun));
                if (relief.spacing > 0) {
                    const std::size_t i = b.index(x, row.y);
                    const Vec3f p{b.position[0][i], b.position[1][i], b.position[2][i]};
                    const double height = relief.base + static_cast<double>(dot(relief.axes[1], p));
                    float cover = contour_cover(relief, height, slopes.at(x, row.y), line_width);
                    if (cover > 0) cover *= gaps.at(x);
                    color = color * (1 - cover) + kContourInk * cover;
                }
                float* pixel = out.pixel(x, row.y - rows.begin);
                pixel[0] = color.x, pixel[1] = color.y, pixel[2] = color.z, pixel[3] = 1;
            }
        });
    return out;
}

}  // namespace slim
