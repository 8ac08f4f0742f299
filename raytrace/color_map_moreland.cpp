// Moreland, "Diverging Color Maps for Scientific Visualization" (ISVC 2009; the expanded version
// gives the algorithm as listings): interpolation in Msh, the polar form of CIELAB, through an
// unsaturated middle.

#include "raytrace/color_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim {
namespace {

struct Msh {
    double m, s, h;
};

constexpr Vec3d kWhiteD65{0.95047, 1.0, 1.08883};

double decode(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double encode(double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

double lab_f(double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; }
double lab_f_inverse(double f) { return f > 0.206893 ? f * f * f : (f - 16.0 / 116) / 7.787; }

Vec3d lab_from_srgb(const Vec3d& c) {
    const double r = decode(c.x), g = decode(c.y), b = decode(c.z);
    const double x = lab_f((0.4124 * r + 0.3576 * g + 0.1805 * b) / kWhiteD65.x);
    const double y = lab_f((0.2126 * r + 0.7152 * g + 0.0722 * b) / kWhiteD65.y);
    const double z = lab_f((0.0193 * r + 0.1192 * g + 0.9505 * b) / kWhiteD65.z);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Vec3d srgb_from_lab(const Vec3d& lab) {
    const double fy = (lab.x + 16) / 116;
    const double x = kWhiteD65.x * lab_f_inverse(fy + lab.y / 500);
    const double y = kWhiteD65.y * lab_f_inverse(fy);
    const double z = kWhiteD65.z * lab_f_inverse(fy - lab.z / 200);
    return {encode(3.2406 * x - 1.5372 * y - 0.4986 * z),
            encode(-0.9689 * x + 1.8758 * y + 0.0415 * z),
            encode(0.0557 * x - 0.2040 * y + 1.0570 * z)};
}

Msh msh_from_lab(const Vec3d& lab) {
    const double m = length(lab);
    return {m, std::acos(lab.x / m), std::atan2(lab.z, lab.y)};
}

Vec3d lab_from_msh(const Msh& c) {
    return {c.m * std::cos(c.s), c.m * std::sin(c.s) * std::cos(c.h),
            c.m * std::sin(c.s) * std::sin(c.h)};
}

/// Listing "AdjustHue": the hue to give the unsaturated end so that the way to it looks straight.
double adjusted_hue(const Msh& saturated, double m_unsaturated) {
    if (saturated.m >= m_unsaturated) return saturated.h;
    const double spin = saturated.s *
                        std::sqrt(m_unsaturated * m_unsaturated - saturated.m * saturated.m) /
                        (saturated.m * std::sin(saturated.s));
    return saturated.h > -std::numbers::pi / 3 ? saturated.h + spin : saturated.h - spin;
}

/// One half of the map: from a saturated end (t = 0) to the middle (t = 1).
Vec3f toward_middle(const Msh& end, double middle_m, double t) {
    const double hue = adjusted_hue(end, middle_m);
    const Msh c{end.m + (middle_m - end.m) * t, end.s * (1 - t), end.h + (hue - end.h) * t};
    const Vec3d srgb = srgb_from_lab(lab_from_msh(c));
    return to_float({std::clamp(srgb.x, 0.0, 1.0), std::clamp(srgb.y, 0.0, 1.0),
                     std::clamp(srgb.z, 0.0, 1.0)});
}

std::vector<Vec3f> diverging_knots(const Vec3d& low, const Vec3d& high) {
    const Msh a = msh_from_lab(lab_from_srgb(low)), b = msh_from_lab(lab_from_srgb(high));
    const double middle_m = std::max({a.m, b.m, 88.0});
    std::vector<Vec3f> knots(ColorMap::kKnots);
    constexpr std::size_t half = ColorMap::kKnots / 2;
    for (std::size_t i = 0; i <= half; ++i) {
        const double t = static_cast<double>(i) / half;
        knots[i] = toward_middle(a, middle_m, t);
        knots[ColorMap::kKnots - 1 - i] = toward_middle(b, middle_m, t);
    }
    // Both halves meet in the same grey; keep it exactly neutral.
    const float grey = (knots[half].x + knots[half].y + knots[half].z) / 3;
    knots[half] = {grey, grey, grey};
    return knots;
}

}  // namespace

const ColorMap& cool_warm() {
    static const ColorMap map(
        "cool-warm", diverging_knots({59.0 / 255, 76.0 / 255, 192.0 / 255},
                                     {180.0 / 255, 4.0 / 255, 38.0 / 255}));
    return map;
}

}  // namespace slim
