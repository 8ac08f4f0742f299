#include "raytrace/lines/crossings.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// Within so many pixels beyond a limb, 2 in a picture 1000 high, a surfel that overshoots ends.
constexpr float kOvershoot = 2;
/// Normals of a limb and what overshoots it.
constexpr float kOvershootTurn = 0.5f;
/// Surfels that blend disagree by up to so many of their residuals (raytrace/lines/notes/0008).
constexpr float kDisagree = 5;
/// A limb lies within so many pixels beyond the last one that faces the eye.
constexpr float kLimbWithin = 2;
constexpr float kJustTurned = 0.3f;  ///< -N.v just beyond one

/// How far beyond the last pixel the limb lies: (N.v)^2 falls about linearly to 0 there (on a
/// sphere seen from afar: 1 - r^2 / R^2). None where it does not fall: at a border of the data,
/// or of a surfel.
std::optional<float> limb_beyond(const LineScene& s, std::size_t last, std::size_t before,
                                 bool have_before) {
    const float f1 = s.facing(last);
    if (!have_before || !s.hit(before) || breaks_off(s, before, last)) return std::nullopt;
    const float f0 = s.facing(before), fall = f0 * f0 - f1 * f1;
    if (!(fall > 0) || !(f1 > 0)) return std::nullopt;
    return f1 * f1 / fall;
}

/// The near pixel of a pair, the other one, and the one before the near one.
struct Brink {
    std::size_t near, far, before;
    bool have_before;
};

/// Whether what is seen beyond the limb turns away and ends within a few pixels: surfels overshoot
/// their limb a little, and the contour is where they end.
bool is_overshoot(const LineScene& s, const Brink& at, int reach) {
    if (s.facing(at.far) >= 0 || dot(s.normal(at.near), s.normal(at.far)) < kOvershootTurn)
        return false;
    const auto width = static_cast<std::ptrdiff_t>(s.buffer.width);
    const auto x = static_cast<std::ptrdiff_t>(at.far) % width,
               y = static_cast<std::ptrdiff_t>(at.far) / width;
    for (const std::ptrdiff_t dy : {-1, 0, 1})
        for (const std::ptrdiff_t dx : {-1, 0, 1})
            for (std::ptrdiff_t k = 1; k <= reach && (dx != 0 || dy != 0); ++k) {
                const std::ptrdiff_t px = x + k * dx, py = y + k * dy;
                if (px < 0 || py < 0 || px >= width || py >= s.buffer.height) break;
                const auto there = static_cast<std::size_t>(py * width + px);
                if (!s.hit(there)) return true;
                if (s.deeper(at.far, there) > 0 && breaks_off(s, at.far, there)) return true;
            }
    return false;
}

/// 1 where the surface turns away or ends before nothing; below 0.5 where the step is none that
/// surfels which disagree would not make.
float clearness(const LineScene& s, const Brink& at, const std::optional<float>& limb) {
    const float facing = s.facing(at.near);
    const bool turns_away =
        (limb && *limb <= kLimbWithin) || (facing <= 0 && facing > -kJustTurned);
    if (!s.hit(at.far) || turns_away) return 1;
    const Vec3f d = s.point(at.far) - s.point(at.near);
    const float off =
        std::fmax(std::fabs(dot(d, s.normal(at.near))), std::fabs(dot(d, s.normal(at.far))));
    const float hair = kDisagree * std::fmax(s.fit_error(at.near), s.fit_error(at.far));
    return off >= 2 * hair ? 1 : 0.5f * off / hair;
}

}  // namespace

CrossingField contour_crossings(const LineScene& s, const Sheets& sheets) {
    const auto width = static_cast<std::size_t>(s.buffer.width), n = s.buffer.n_pixels();
    const auto weight = static_cast<float>(1 / s.diagonal);
    const float side = static_cast<float>(std::min(s.buffer.width, s.picture_height()));
    const int reach = static_cast<int>(std::max(kOvershoot, std::round(kOvershoot * side / 1000)));
    const auto may = [&sheets](bool down, std::size_t y, std::size_t x) {
        const auto row = static_cast<std::ptrdiff_t>(y), column = static_cast<std::ptrdiff_t>(x);
        const std::uint32_t other = sheets.hit.at(row + (down ? 1 : 0), column + (down ? 0 : 1));
        const std::uint32_t seen = sheets.hit.at(row, column) | other;
        return seen & ~sheets.to(down).unbroken.at(row, column) & sheets.pairs(down, y, x);
    };
    return find_crossings(s, may, [=, &s](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
        const bool hit_a = s.hit(a), hit_b = s.hit(b);
        const bool a_is_near = hit_a && (!hit_b || s.deeper(a, b) > 0);
        const bool down = b != a + 1;
        const std::size_t step = down ? width : 1;
        const Brink at = a_is_near
                             ? Brink{a, b, a - step, down ? a >= step : a % width > 0}
                             : Brink{b, a, b + step, down ? b + step < n : (b + 1) % width > 0};
        if (s.hit(at.far) && is_overshoot(s, at, reach)) return std::nullopt;
        const std::optional<float> limb = limb_beyond(s, at.near, at.before, at.have_before);
        const float beyond = limb && *limb < 1 ? std::clamp(*limb, 0.02f, 0.98f) : 0.5f;
        return EdgeHit{a_is_near ? beyond : 1 - beyond, weight, clearness(s, at, limb),
                       a_is_near ? EdgeHit::Side::a : EdgeHit::Side::b};
    });
}

}  // namespace slim
