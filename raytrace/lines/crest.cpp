#include "raytrace/lines/crossings.h"
#include "raytrace/lines/sheet_blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slim {
namespace {

/// One family of crest lines seen as ridges: ravines are those of the surface turned inside out.
struct Family {
    const LineScene& s;
    bool ridges;

    float k(std::size_t i) const { return ridges ? s.buffer.k1[i] : -s.buffer.k2[i]; }
    float other(std::size_t i) const { return ridges ? s.buffer.k2[i] : s.buffer.k1[i]; }
    float e(std::size_t i) const { return ridges ? s.buffer.third[0][i] : -s.buffer.third[3][i]; }
    Vec3f direction(std::size_t i) const {
        const auto& t = s.buffer.direction;
        const Vec3f t1{t[0][i], t[1][i], t[2][i]};
        return ridges ? t1 : cross(s.normal(i), t1);
    }
    /// More curved than the other way, so that the direction means something.
    bool bends(std::size_t i) const { return k(i) > std::fabs(other(i)); }
};

/// v = e t, which does not change with the sign of t, averaged over some pixels of a sheet. Within
/// one cubic surfel e falls along t as on a parabola (by 3 k^3, its fourth derivative is not there)
/// and jumps back to the next: the average takes the saw's teeth out of the lines.
std::array<std::vector<float>, 3> smooth_rises(const Family& f, const SheetBlur& blur) {
    const LineScene& s = f.s;
    std::array<std::vector<float>, 3> rise;
    for (auto& plane : rise) plane.assign(s.buffer.n_pixels(), 0.0f);
    const auto width = static_cast<std::size_t>(s.buffer.width);
    parallel_blocks(s.buffer.n_pixels(), width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!s.hit(i)) continue;
            const Vec3f v = f.direction(i) * f.e(i);
            for (std::size_t axis = 0; axis < 3; ++axis) rise[axis][i] = v[axis];
        }
    });
    blur(rise);
    return rise;
}

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// How much k has fallen at a distance along t, as a share; NaN where that is not on the surface
/// seen.
float fall_at(const Family& f, std::size_t i, const Vec3f& p, float k) {
    const LineScene& s = f.s;
    const Vec3d c = s.view.camera_from_local(to_double(p));
    const double scale = s.view.orthographic ? s.view.px_per_unit : s.view.focal_px / c.z;
    const double x = s.view.center_x + scale * c.x, y = s.view.center_y + scale * c.y;
    if (!(x >= 0 && y >= 0 && x < s.buffer.width && y < s.buffer.height)) return kNone;
    const std::size_t j = s.buffer.index(static_cast<int>(x), static_cast<int>(y));
    const Vec3f q = s.point(i);
    if (!s.hit(j) || sq_length(s.point(j) - q) > 4 * sq_length(p - q)) return kNone;
    return 1 - f.k(j) / k;
}

/// Where the osculating circle along t leads after an angle.
Vec3f along_circle(const Family& f, std::size_t i, float k, float angle) {
    const Vec3f inwards = f.s.normal(i) * (f.ridges ? -1.0f : 1.0f);
    return f.s.point(i) +
           (f.direction(i) * std::sin(angle) + inwards * (1 - std::cos(angle))) * (1 / k);
}

/// Sharpness of a ridge: the fall of k to either side, as the -k''/k^3 that would make it; the
/// lesser of the sides that are seen, NaN if none is. 0 on a torus, about 3 (1 - b^2/a^2) at the
/// tip of an ellipse. Looks as far as the normal turns by 40 degrees (3 to 40 pixels), nearer where
/// the limb is nearer.
///
/// Departs from NUMERICS 5.4, which has no such test: e alone has false zeros at every surfel.
float sharpness(const Family& f, std::size_t i, float k) {
    constexpr float kTurn = 0.7f, kMostTurn = 1.2f;
    const float width_turn = f.s.footprint(i) * k;
    float turn = std::min(std::clamp(kTurn, 3 * width_turn, 40 * width_turn), kMostTurn);
    for (int look = 0; look < 3; ++look, turn *= 0.5f) {
        float least = kNone;
        for (const float side : {-turn, turn})
            least = std::fmin(least, fall_at(f, i, along_circle(f, i, k, side), k));
        if (!std::isnan(least)) return std::clamp(2 * least / (turn * turn), -1.0f, 4.0f);
    }
    return kNone;
}

/// An edge that the view shows within a pixel (a sheet of sharp surfels against the next, or too
/// fine a rounding): N turns by 30 degrees or more there. No derivative tells it; its k is the turn
/// over the way.
bool is_crease(const LineScene& s, std::size_t a, std::size_t b) {
    return s.hit(a) && s.hit(b) && dot(s.normal(a), s.normal(b)) < 0.866f && !breaks_off(s, a, b);
}

std::optional<EdgeHit> crease(const Family& f, std::size_t a, std::size_t b) {
    constexpr float kSharp = 4;  // as the sharpest of crest lines
    const Vec3f na = f.s.normal(a), nb = f.s.normal(b), d = f.s.point(b) - f.s.point(a);
    if ((dot(nb - na, d) > 0) != f.ridges) return std::nullopt;
    // Where the tangent planes meet, seen along d.
    const float from_a = std::fabs(dot(nb, d)), from_b = std::fabs(dot(na, d));
    const float at = from_a + from_b > 0 ? from_a / (from_a + from_b) : 0.5f;
    return EdgeHit{at, std::acos(std::clamp(dot(na, nb), -1.0f, 1.0f)) / length(d), kSharp};
}

}  // namespace

CrossingField crest_crossings(const LineScene& s, const SheetBlur& blur, bool ridges) {
    const Family f{s, ridges};
    const auto rises = smooth_rises(f, blur);
    const auto rise = [&](std::size_t i) { return Vec3f{rises[0][i], rises[1][i], rises[2][i]}; };
    return find_crossings(s, [&](std::size_t a, std::size_t b) -> std::optional<EdgeHit> {
        if (is_crease(s, a, b)) return crease(f, a, b);
        if (!f.bends(a) || !f.bends(b)) return std::nullopt;
        const Vec3f ta = f.direction(a), across = f.direction(b);
        const float turn = dot(ta, across);
        if (!(std::fabs(turn) > 0.7f)) return std::nullopt;
        const Vec3f tb = across * std::copysign(1.0f, turn);
        const float ea = dot(rise(a), ta), eb = dot(rise(b), tb);
        if ((ea > 0) == (eb > 0) || !one_sheet(s, a, b)) return std::nullopt;
        // k rises from both sides towards a ridge. An edge that runs along it cannot tell; its
        // neighbours can.
        const Vec3f d = s.point(b) - s.point(a);
        const float along = dot(ta + tb, d);
        const bool tells = along * along > 0.36f * sq_length(d);
        if (tells && !(ea * along > 0)) return std::nullopt;
        const float at = ea / (ea - eb), k = f.k(a) * (1 - at) + f.k(b) * at;
        const float sharp = sharpness(f, at < 0.5f ? a : b, k);
        if (!(sharp > -0.5f)) return std::nullopt;
        return EdgeHit{at, k, sharp};
    });
}

}  // namespace slim
