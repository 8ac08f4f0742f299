#include "raytrace/project/outline.h"

#include "raytrace/project/linear_forms.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// |q|^2 - w^2 + ratio (w - middle)^2 < sq_across, in units of rho, w along the normal.
struct Ellipsoid {
    double middle, ratio, sq_across;
};

/// Holds u^2 + v^2 <= r^2, |w - middle| <= h, whose half axes are r sqrt(1 + k) and h sqrt(1 + 1 / k) for any k > 0: the one
/// whose outline has the least area where the normal makes an angle of this squared cosine with the view.
Ellipsoid least_ellipsoid(double low, double high, double radius, double sq_cos) {
    const double middle = 0.5 * (low + high), half = std::max(0.5 * (high - low), 1e-4);
    const double nearest = std::max({0.0, low, -high});
    const double sq_r = std::max(radius * radius - nearest * nearest, 1e-6);
    // The area's square is r^2 (1 + k)^2 (r^2 cos^2 + h^2 sin^2 / k).
    const double thick = half * half * (1 - sq_cos) / (sq_r * sq_cos + 1e-6);
    const double k = 2 * thick / (thick + std::sqrt(thick * thick + 8 * thick) + 1e-12) + 1e-3;
    const Ellipsoid e{middle, k * sq_r / (half * half), sq_r * (1 + k)};
    // Of a thick patch the ball's own outline is the lesser one.
    const double sq_ball = radius * radius;
    if (e.sq_across * e.sq_across * (sq_cos + (1 - sq_cos) / e.ratio) > sq_ball * sq_ball) return {0, 1, sq_ball};
    return e;
}

/// m[i][j] of a quadric in (1, s, t, tau).
struct Quadric {
    double m00, m0s, m0t, mss, mst, mtt;  ///< of what has no tau
    double t0, ts, tt;                    ///< of 2 tau (t0 + ts s + tt t)
    double tau2;
};

/// h^2 times the ellipsoid's.
Quadric seen(const RayForm& f, const Vec3d& n, const Ellipsoid& e) {
    const double w = dot(n, f.mu), d0 = -e.middle, d = w + e.middle * f.kappa, b = e.ratio;
    return {b * d0 * d0 - e.sq_across,
            b * d0 * n.x,
            b * d0 * n.y,
            1 + (b - 1) * n.x * n.x,
            (b - 1) * n.x * n.y,
            1 + (b - 1) * n.y * n.y,
            b * d0 * d + e.sq_across * f.kappa,
            f.mu.x + (b * d - w) * n.x,
            f.mu.y + (b * d - w) * n.y,
            sq_length(f.mu) + b * d * d - w * w - e.sq_across * f.kappa * f.kappa};
}

/// Rays that touch it: those along which the discriminant in tau is zero. a s^2 + 2 (b0 + b1 t) s + c0 + 2 c1 t + c2 t^2.
struct Conic {
    double a, b0, b1, c0, c1, c2;

    explicit Conic(const Quadric& q)
        : a(q.tau2 * q.mss - q.ts * q.ts), b0(q.tau2 * q.m0s - q.t0 * q.ts), b1(q.tau2 * q.mst - q.ts * q.tt),
          c0(q.tau2 * q.m00 - q.t0 * q.t0), c1(q.tau2 * q.m0t - q.t0 * q.tt), c2(q.tau2 * q.mtt - q.tt * q.tt) {}
};

/// Middle and half width of an interval.
struct Extent {
    double middle, half;
};

/// How far an ellipse reaches: where the discriminant in the other variable is zero.
struct Extents {
    Extent s, t;
    explicit Extents(const Conic& c) {
        const double inverse = 1 / (c.a * c.c2 - c.b1 * c.b1);
        s.middle = (c.b1 * c.c1 - c.c2 * c.b0) * inverse, t.middle = (c.b1 * c.b0 - c.a * c.c1) * inverse;
        // f there: minus the squared half widths over those of s^2 and t^2 alone.
        const double deepest = -(c.c0 + c.b0 * s.middle + c.c1 * t.middle) * inverse;
        s.half = std::sqrt(std::max(0.0, c.c2 * deepest)), t.half = std::sqrt(std::max(0.0, c.a * deepest));
    }
};

Outline outline_of(const Conic& c, const Extents& e) {
    const double inverse = 1 / c.a;
    const auto scaled = [&](double x) { return static_cast<float>(x * inverse); };
    // The places of the extremes in s lie on the line through the middle where the derivative in t is zero.
    const double shift = c.b1 / c.c2 * e.s.half;
    return {scaled(c.b0), scaled(c.b1), scaled(c.c0), scaled(c.c1), scaled(c.c2),
            static_cast<float>(e.t.middle + shift), static_cast<float>(e.t.middle - shift)};
}

ScreenRect rect_of(const PixelWindow& w, const RayForm& f, const Extents& e) {
    const double per_px = 1 / f.step, x = f.origin_x + e.s.middle * per_px, y = f.origin_y + e.t.middle * per_px;
    ScreenRect rect{w.x, w.y, w.x + w.width, w.y + w.height};
    pixel_range(x - e.s.half * per_px, x + e.s.half * per_px, rect.x0, rect.x1, rect.x0, rect.x1);
    pixel_range(y - e.t.half * per_px, y + e.t.half * per_px, rect.y0, rect.y1, rect.y0, rect.y1);
    return rect;
}

}  // namespace

OutlinedRect patch_outline(const PixelWindow& window, const RayForm& form, const Vec3d& normal, double support_radius,
                           const PatchBounds& p) {
    const double inverse = 1 / support_radius, w = dot(normal, form.mu);
    const double sq_cos = w * w / sq_length(form.mu);
    const Conic conic(seen(form, normal, least_ellipsoid(p.low * inverse, p.high * inverse, p.radius * inverse, sq_cos)));
    const Extents extents(conic);
    return {outline_of(conic, extents), rect_of(window, form, extents)};
}

}  // namespace slim
