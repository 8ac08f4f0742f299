#include "raytrace/lines/crossings.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// How far beyond the last pixel the limb lies: (N.v)^2 falls about linearly to 0 there (on a
/// sphere seen from afar: 1 - r^2 / R^2). Half-way where it does not fall: at a border of the data.
float beyond_last(const LineScene& s, std::size_t last, std::size_t before, bool have_before) {
    if (!have_before || !s.hit(before) || breaks_off(s, before, last)) return 0.5f;
    const float f1 = s.facing(last), f0 = s.facing(before);
    const float fall = f0 * f0 - f1 * f1;
    if (!(fall > 0) || !(f1 > 0)) return 0.5f;
    const float share = f1 * f1 / fall;
    return share < 1 ? std::clamp(share, 0.02f, 0.98f) : 0.5f;
}

}  // namespace

CrossingField contour_crossings(const LineScene& s, const Sheets& sheets) {
    const auto width = static_cast<std::size_t>(s.buffer.width), n = s.buffer.n_pixels();
    const auto weight = static_cast<float>(1 / s.diagonal);
    const auto may = [&sheets](bool down, std::size_t y, std::size_t x) {
        const auto row = static_cast<std::ptrdiff_t>(y), column = static_cast<std::ptrdiff_t>(x);
        const std::uint32_t other = sheets.hit.at(row + (down ? 1 : 0), column + (down ? 0 : 1));
        const std::uint32_t seen = sheets.hit.at(row, column) | other;
        return seen & ~sheets.to(down).unbroken.at(row, column) & sheets.pairs(down, y, x);
    };
    return find_crossings(s, may, [=, &s](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
        const bool hit_a = s.hit(a), hit_b = s.hit(b);
        const bool a_is_near = hit_a && (!hit_b || s.depth(a) < s.depth(b));
        const bool down = b != a + 1;
        const std::size_t step = down ? width : 1;
        EdgeHit hit{0.5f, weight, 1, a_is_near ? EdgeHit::Side::a : EdgeHit::Side::b};
        if (a_is_near)
            hit.s = beyond_last(s, a, a - step, down ? a >= step : a % width > 0);
        else
            hit.s = 1 - beyond_last(s, b, b + step, down ? b + step < n : (b + 1) % width > 0);
        return hit;
    });
}

}  // namespace slim
