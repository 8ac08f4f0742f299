#include "raytrace/project/outline.h"

#include "slim/base/lane_turns.h"

#include <array>
#include <cstddef>

namespace slim {
namespace {

/// |q|^2 - w^2 + ratio (w - middle)^2 < sq_across, in units of rho, w along the normal.
struct Ellipsoid {
    DoubleV middle, ratio, sq_across;
};

/// Holds u^2 + v^2 <= r^2, |w - middle| <= h, whose half axes are r sqrt(1 + k) and h sqrt(1 + 1 /
/// k) for any k > 0: the one whose outline has the least area where the normal makes an angle of
/// this squared cosine with the view.
Ellipsoid least_ellipsoid(const DoubleV& low, const DoubleV& high, const DoubleV& radius,
                          const DoubleV& sq_cos) {
    const DoubleV middle = 0.5 * (low + high), half = stdx::max(0.5 * (high - low), DoubleV(1e-4));
    const DoubleV nearest = stdx::max(stdx::max(DoubleV(0.0), low), -high);
    const DoubleV sq_r = stdx::max(radius * radius - nearest * nearest, DoubleV(1e-6)),
                  sq_sin = 1.0 - sq_cos;
    // The area's square is r^2 (1 + k)^2 (r^2 cos^2 + h^2 sin^2 / k).
    const DoubleV thick = half * half * sq_sin / (sq_r * sq_cos + 1e-6);
    const DoubleV k =
        2.0 * thick / (thick + stdx::sqrt(thick * thick + 8.0 * thick) + 1e-12) + 1e-3;
    const DoubleV ratio = k * sq_r / (half * half), sq_across = sq_r * (1.0 + k);
    // Of a thick patch the ball's own outline is the lesser one.
    const DoubleV sq_ball = radius * radius;
    const auto is_thick = sq_across * sq_across * (sq_cos + sq_sin / ratio) > sq_ball * sq_ball;
    return {select<DoubleV>(is_thick, DoubleV(0.0), middle),
            select<DoubleV>(is_thick, DoubleV(1.0), ratio),
            select<DoubleV>(is_thick, sq_ball, sq_across)};
}

/// m[i][j] of a quadric in (1, s, t, tau).
struct Quadric {
    DoubleV m00, m0s, m0t, mss, mst, mtt;  ///< of what has no tau
    DoubleV t0, ts, tt;                    ///< of 2 tau (t0 + ts s + tt t)
    DoubleV tau2;
};

/// h^2 times the ellipsoid's.
Quadric seen(const RayForm& f, const Vec3D& n, const Ellipsoid& e) {
    const DoubleV w = dot(n, f.mu), d0 = -e.middle, d = w + e.middle * f.kappa, b = e.ratio;
    return {b * d0 * d0 - e.sq_across,
            b * d0 * n.x,
            b * d0 * n.y,
            1.0 + (b - 1.0) * n.x * n.x,
            (b - 1.0) * n.x * n.y,
            1.0 + (b - 1.0) * n.y * n.y,
            b * d0 * d + e.sq_across * f.kappa,
            f.mu.x + (b * d - w) * n.x,
            f.mu.y + (b * d - w) * n.y,
            sq_length(f.mu) + b * d * d - w * w - e.sq_across * f.kappa * f.kappa};
}

/// Rays that touch it: those along which the discriminant in tau is zero. a s^2 + 2 (b0 + b1 t) s +
/// c0 + 2 c1 t + c2 t^2.
struct Conic {
    DoubleV a, b0, b1, c0, c1, c2;

    explicit Conic(const Quadric& q)
        : a(q.tau2 * q.mss - q.ts * q.ts),
          b0(q.tau2 * q.m0s - q.t0 * q.ts),
          b1(q.tau2 * q.mst - q.ts * q.tt),
          c0(q.tau2 * q.m00 - q.t0 * q.t0),
          c1(q.tau2 * q.m0t - q.t0 * q.tt),
          c2(q.tau2 * q.mtt - q.tt * q.tt) {}
};

/// Middle and half width of an interval.
struct Extent {
    DoubleV middle, half;
};

/// How far an ellipse reaches: where the discriminant in the other variable is zero.
struct Extents {
    Extent s, t;
    explicit Extents(const Conic& c) {
        const DoubleV inverse = 1.0 / (c.a * c.c2 - c.b1 * c.b1);
        s.middle = (c.b1 * c.c1 - c.c2 * c.b0) * inverse,
        t.middle = (c.b1 * c.b0 - c.a * c.c1) * inverse;
        // f there: minus the squared half widths over those of s^2 and t^2 alone.
        const DoubleV deepest = -(c.c0 + c.b0 * s.middle + c.c1 * t.middle) * inverse;
        const DoubleV zero(0.0);
        s.half = stdx::sqrt(stdx::max(zero, c.c2 * deepest)),
        t.half = stdx::sqrt(stdx::max(zero, c.a * deepest));
    }
};

using Ints = LanesOfDouble<int>;

/// Pixel indices whose centres lie in some intervals of pixel coordinates, clipped to [begin, end):
/// first ones and those after the last.
void pixel_ranges(const DoubleV& lo, const DoubleV& hi, int begin, int end, Ints& first,
                  Ints& last) {
    const auto within = [&](const DoubleV& x) {
        return stdx::static_simd_cast<Ints>(
            stdx::min(stdx::max(x, DoubleV(double(begin))), DoubleV(double(end))));
    };
    first = within(stdx::ceil(lo - 0.5 - kPixelGuard)),
    last = within(stdx::floor(hi - 0.5 + kPixelGuard) + 1.0);
}

}  // namespace

[[gnu::flatten]] Footprints::Footprints(const PixelWindow& window, const RayForm& form,
                                        const PixelGrid& grid, const SurfelLanes& s,
                                        const PatchBounds& p) {
    const DoubleV inverse_radius = 1.0 / s.radius, w = dot(s.e_w, form.mu);
    const DoubleV sq_cos = w * w / sq_length(form.mu);
    const Conic c(seen(form, s.e_w, least_ellipsoid(p.low * inverse_radius, p.high * inverse_radius,
                                                    p.radius * inverse_radius, sq_cos)));
    const Extents e(c);
    const DoubleV inverse = 1.0 / c.a;
    // The places of the extremes in s lie on the line through the middle where the derivative in t
    // is zero.
    const DoubleV shift = c.b1 / c.c2 * e.s.half;
    const std::array<DoubleV, 7> numbers{c.b0 * inverse,    c.b1 * inverse, c.c0 * inverse,
                                         c.c1 * inverse,    c.c2 * inverse, e.t.middle + shift,
                                         e.t.middle - shift};
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers_[k] = floats_of(numbers[k]);
    numbers_[7] = grid.pixel_x, numbers_[8] = grid.pixel_y;
    numbers_[9] = grid.base_x, numbers_[10] = grid.base_y, numbers_[11] = grid.step;
    const DoubleV per_px = 1.0 / form.step, half_x = e.s.half * per_px, half_y = e.t.half * per_px;
    const DoubleV x = form.origin_x + e.s.middle * per_px, y = form.origin_y + e.t.middle * per_px;
    pixel_ranges(x - half_x, x + half_x, window.x, window.x + window.width, sides_[0], sides_[2]);
    pixel_ranges(y - half_y, y + half_y, window.y, window.y + window.height, sides_[1], sides_[3]);
}

void Footprints::put(const std::array<Footprint*, kSurfelLanes>& out) const {
    static_assert(sizeof(Footprint) == 16 * sizeof(float) &&
                  offsetof(Footprint, rect) == 12 * sizeof(float));
    const auto& n = numbers_;
    for (std::size_t k = 0; k < n.size(); k += 4)
        store_fours(n[k], n[k + 1], n[k + 2], n[k + 3],
                    [&](std::size_t lane) { return reinterpret_cast<float*>(out[lane]) + k; });
    alignas(64) int sides[4][kSurfelLanes];
    for (std::size_t k = 0; k < 4; ++k) sides_[k].copy_to(sides[k], stdx::vector_aligned);
    for (std::size_t lane = 0; lane < kSurfelLanes; ++lane)
        out[lane]->rect = {sides[0][lane], sides[1][lane], sides[2][lane], sides[3][lane]};
}

}  // namespace slim
