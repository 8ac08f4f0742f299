#include "raytrace/color_map.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <vector>

namespace slim {
namespace {

/// 0xRRGGBB as sRGB components.
constexpr Vec3f from_hex(std::uint32_t rgb) {
    return {static_cast<float>(rgb >> 16 & 255) / 255.0f,
            static_cast<float>(rgb >> 8 & 255) / 255.0f, static_cast<float>(rgb & 255) / 255.0f};
}

template <std::size_t n>
ColorMap from_hex_knots(const char* name, const std::uint32_t (&knots)[n]) {
    std::vector<Vec3f> colors;
    for (const std::uint32_t knot : knots) colors.push_back(from_hex(knot));
    return ColorMap(name, colors);
}

double smallest_nice_step(double mantissa) {
    for (const double step : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (mantissa <= step * (1 + 1e-6)) return step;
    return 10;
}

}  // namespace

ColorMap::ColorMap(std::string name, std::span<const Vec3f> knots) : name_(std::move(name)) {
    SLIM_CHECK(knots.size(), >=, 2u);
    for (std::size_t i = 0; i < kKnots; ++i) {
        const float at =
            static_cast<float>(i * (knots.size() - 1)) / static_cast<float>(kKnots - 1);
        const std::size_t k = std::min(static_cast<std::size_t>(at), knots.size() - 2);
        const float t = at - static_cast<float>(k);
        const Vec3f c = knots[k] * (1 - t) + knots[k + 1] * t;
        srgb_[i] = c;
        linear_[i] = {linear_from_srgb(c.x), linear_from_srgb(c.y), linear_from_srgb(c.z)};
    }
}

Vec3f ColorMap::interpolate(const Table& table, float t) {
    const float at = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(kKnots - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(at), kKnots - 2);
    const float fraction = at - static_cast<float>(k);
    return table[k] * (1 - fraction) + table[k + 1] * fraction;
}

const ColorMap& viridis() {
    static const ColorMap map =
        from_hex_knots("viridis", {0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e,
                                   0x2a788e, 0x23888e, 0x1f988b, 0x22a884, 0x35b779, 0x54c568,
                                   0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725});
    return map;
}

const ColorMap& cividis() {
    static const ColorMap map =
        from_hex_knots("cividis", {0x00224e, 0x002e6c, 0x1e3a6f, 0x35456c, 0x47516c, 0x575d6d,
                                   0x666970, 0x757575, 0x848279, 0x948e77, 0xa59c74, 0xb7a96e,
                                   0xc8b866, 0xdbc75a, 0xeed649, 0xfee838});
    return map;
}

double nice_ceiling(double v) {
    if (!(v > 0) || !std::isfinite(v)) return 0;
    const double digits = std::floor(std::log10(v)), power = std::pow(10.0, digits);
    const double step = smallest_nice_step(v / power);
    // A quotient is the nearest number, 0.15, where a product is 0.15000000000000002.
    return digits < 0 && digits >= -22 ? step / std::pow(10.0, -digits) : step * power;
}

float place_on_map(const ValueRange& r, double value) {
    if (!r.about_zero || r.lo == -r.hi) return static_cast<float>((value - r.lo) / (r.hi - r.lo));
    const double v = std::clamp(value, r.lo, r.hi);
    return static_cast<float>(v >= 0 ? 0.5 + (v > 0 ? 0.5 * v / r.hi : 0) : 0.5 - 0.5 * v / r.lo);
}

double percentile_of_abs(std::span<const float> values, std::span<const std::uint8_t> hit,
                         double percentile, double flat) {
    SLIM_CHECK(values.size(), ==, hit.size());
    std::vector<float> covered;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (hit[i] && std::isfinite(values[i])) covered.push_back(std::abs(values[i]));
    if (covered.empty()) return 0;
    constexpr std::ptrdiff_t kFewest = 1000;  // one in so many
    const auto curved = std::partition(covered.begin(), covered.end(),
                                       [&](float v) { return static_cast<double>(v) <= flat; });
    const std::ptrdiff_t n_curved = covered.end() - curved, n = std::ssize(covered);
    if (flat > 0 && 2 * n_curved <= n && kFewest * n_curved >= n)
        covered.erase(covered.begin(), curved);
    const double rank = std::ceil(percentile / 100 * static_cast<double>(covered.size()));
    const std::size_t k = std::min(covered.size() - 1,
                                   static_cast<std::size_t>(std::max(rank, 1.0)) - 1);
    std::nth_element(covered.begin(), covered.begin() + static_cast<std::ptrdiff_t>(k),
                     covered.end());
    return covered[k];
}

ValueRange symmetric_range(double most, double least) {
    const double a = nice_ceiling(std::max(most, least));
    return {-a, a};
}

ValueRange full_range(std::span<const float> values, std::span<const std::uint8_t> hit) {
    SLIM_CHECK(values.size(), ==, hit.size());
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!hit[i] || !std::isfinite(values[i])) continue;
        lo = std::min(lo, static_cast<double>(values[i]));
        hi = std::max(hi, static_cast<double>(values[i]));
    }
    if (!(lo <= hi)) return {0, 1};
    const double least = 1e-6 * std::max({std::abs(lo), std::abs(hi), 1e-30});
    return hi - lo < least ? ValueRange{lo - least, hi + least} : ValueRange{lo, hi};
}

Picture paint(int width, int height, const ColorMap& map, const ValueRange& range,
              std::span<const float> values, std::span<const std::uint8_t> hit) {
    Picture out(width, height);
    SLIM_CHECK(values.size(), ==, out.n_pixels());
    SLIM_CHECK(hit.size(), ==, out.n_pixels());
    SLIM_CHECK(range.lo, <, range.hi);
    parallel_blocks(out.n_pixels(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!hit[i] || std::isnan(values[i])) continue;
            const Vec3f c = map.linear(place_on_map(range, static_cast<double>(values[i])));
            float* p = &out.rgba[4 * i];
            p[0] = c.x, p[1] = c.y, p[2] = c.z, p[3] = 1;
        }
    });
    return out;
}

}  // namespace slim
