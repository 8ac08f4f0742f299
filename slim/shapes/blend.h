#pragma once

#include "slim/shapes/jet2.h"

#include <cmath>

namespace slim {

// Building blocks of implicit shapes over T = double or Jet2; negative inside, near to distances.

template <class T>
T square(const T& a) {
    return a * a;
}

/// |v| for any number type (slim::length is for built-in ones).
template <class T>
T norm(const Vec3<T>& v) {
    using std::sqrt;
    return sqrt(square(v.x) + square(v.y) + square(v.z));
}

template <class T>
T hypot2(const T& a, const T& b) {
    using std::sqrt;
    return sqrt(square(a) + square(b));
}

/// Union, intersection with a crease.
template <class T>
T sharp_min(const T& a, const T& b) {
    return value_of(a) < value_of(b) ? a : b;
}
template <class T>
T sharp_max(const T& a, const T& b) {
    return value_of(a) < value_of(b) ? b : a;
}
template <class T>
T absolute(const T& a) {
    return value_of(a) < 0 ? -a : a;
}

/// Union, intersection with a fillet where |a - b| < k, exactly min and max elsewhere: with
/// h = (1 - |a - b| / k)+, min - k h^3 (4 - h) / 16. Twice continuously differentiable, so
/// curvature is continuous at the fillet's border. Keeps the larger Lipschitz constant.
template <class T>
T smooth_min(const T& a, const T& b, double k) {
    const T gap = absolute(T(a - b));
    if (value_of(gap) >= k) return sharp_min(a, b);
    const T h = 1.0 - gap / k;
    return sharp_min(a, b) - (k / 16) * h * square(h) * (4.0 - h);
}
template <class T>
T smooth_max(const T& a, const T& b, double k) {
    return -smooth_min(T(-a), T(-b), k);
}

/// 0 to 1 around `at`, with slope 1 / (2 width) there; algebraic, smooth everywhere.
template <class T>
T fade_in(const T& a, double at, double width) {
    using std::sqrt;
    const T s = (a - at) / width;
    return 0.5 + 0.5 * s / sqrt(1.0 + square(s));
}

/// Rotated about an axis through the origin by the angle with this cosine and sine (p in the x-y,
/// x-z or y-z plane by choice of arguments): (a, b) -> (c a - s b, s a + c b).
template <class T>
void rotate(T& a, T& b, double angle_rad) {
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    const T a0 = a;
    a = c * a0 - s * b;
    b = s * a0 + c * b;
}

template <class T>
Vec3<T> moved(const Vec3<T>& p, double x, double y, double z) {
    return {p.x - x, p.y - y, p.z - z};
}

/// Box with sharp edges, of half sizes h: exact inside and along faces, within sqrt(3) at corners.
template <class T>
T box(const Vec3<T>& p, const Vec3d& h) {
    return sharp_max(sharp_max(T(absolute(p.x) - h.x), T(absolute(p.y) - h.y)),
                     T(absolute(p.z) - h.z));
}

/// Ellipsoid with half axes r: |p / r| - 1 times the least axis; gradient <= 1 everywhere.
template <class T>
T ellipsoid(const Vec3<T>& p, const Vec3d& r) {
    const double least = r.x < r.y ? (r.x < r.z ? r.x : r.z) : (r.y < r.z ? r.y : r.z);
    return least * (norm(Vec3<T>{p.x / r.x, p.y / r.y, p.z / r.z}) - 1.0);
}

/// Torus about the z axis: exact distance.
template <class T>
T torus_z(const Vec3<T>& p, double major, double minor) {
    return hypot2(T(hypot2(p.x, p.y) - major), p.z) - minor;
}

/// Cone frustum-like capsule from a (radius ra) to b (radius rb): the radius is interpolated with a
/// smooth clamp, so the form is smooth everywhere outside its axis.
template <class T>
T tapered_capsule(const Vec3<T>& p, const Vec3d& a, const Vec3d& b, double ra, double rb) {
    const Vec3d ab = b - a;
    const T along =
        ((p.x - a.x) * ab.x + (p.y - a.y) * ab.y + (p.z - a.z) * ab.z) / sq_length(ab);
    const T t = smooth_min(smooth_max(along, T(0.0), 0.15), T(1.0), 0.15);
    const Vec3<T> d{p.x - a.x - t * ab.x, p.y - a.y - t * ab.y, p.z - a.z - t * ab.z};
    return norm(d) - (ra + (rb - ra) * t);
}

}  // namespace slim
