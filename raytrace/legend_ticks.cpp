#include "raytrace/legend.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slim {
namespace {

constexpr double kTolerance = 1e-6;  // of a step: ticks are short decimal numbers

std::vector<double> multiples_inside(const ValueRange& r, double step) {
    std::vector<double> ticks;
    const double first = std::ceil(r.lo / step - kTolerance);
    const double last = std::floor(r.hi / step + kTolerance);
    for (double k = first; k <= last && ticks.size() < 16; ++k) ticks.push_back(k * step);
    return ticks;
}

/// Largest step of the form {1, 2, 2.5, 5} * 10^k that makes at least `least` ticks.
double round_step(const ValueRange& r, std::size_t least) {
    const double span = r.hi - r.lo;
    double power = std::pow(10.0, std::ceil(std::log10(span)));
    for (int down = 0; down < 4; ++down, power /= 10)
        for (const double digit : {5.0, 2.5, 2.0, 1.0})
            if (multiples_inside(r, digit * power).size() >= least) return digit * power;
    return span / 4;
}

double greatest(const std::vector<double>& ticks) {
    double most = 0;
    for (const double t : ticks) most = std::max(most, std::abs(t));
    return most;
}

/// Digits after the point that show every tick exactly when all are divided by `unit`.
int decimals_needed(const std::vector<double>& ticks, double unit) {
    double step = greatest(ticks);
    for (std::size_t i = 1; i < ticks.size(); ++i) step = std::min(step, ticks[i] - ticks[i - 1]);
    for (int n = 0; n < 8; ++n) {
        const double scale = std::pow(10.0, n) / unit;
        const bool exact = std::all_of(ticks.begin(), ticks.end(), [&](double t) {
            return std::abs(t * scale - std::round(t * scale)) < 1e-3 * step * scale;
        });
        if (exact) return n;
    }
    return 8;
}

std::string with_minus_sign(const char* text) {
    std::string out;
    for (; *text; ++text) out += *text == '-' ? std::string("\u2212") : std::string(1, *text);
    return out;
}

}  // namespace

std::vector<double> legend_ticks(const ValueRange& range) {
    if (range.lo == -range.hi)
        return {-range.hi, -range.hi / 2, 0, range.hi / 2, range.hi};
    return multiples_inside(range, round_step(range, 4));
}

std::string tick_label(double value, const std::vector<double>& ticks) {
    const double most = greatest(ticks);
    char text[64];
    if (value == 0 || most == 0) return "0";
    if (most >= 1e-3 && most < 1e6) {
        std::snprintf(text, sizeof text, "%.*f", decimals_needed(ticks, 1), value);
        return with_minus_sign(text);
    }
    const double exponent = std::floor(std::log10(most) + 1e-9);
    const double unit = std::pow(10.0, exponent);
    std::snprintf(text, sizeof text, "%.*fe%.0f", decimals_needed(ticks, unit), value / unit,
                  exponent);
    return with_minus_sign(text);
}

}  // namespace slim
