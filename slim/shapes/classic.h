#pragma once

#include "slim/shapes/blend.h"

namespace slim {

// The classic test surfaces as implicit functions over T = double or Jet2. Sizes as in the clouds
// that the peers were measured on: unit sphere, torus 1/0.35, ellipsoid 1/0.7/0.4, bumpy sphere.
// foot(p), where there is a closed form: the nearest point of f = 0; any of several.

namespace shape_detail {

/// The point of the half plane through p and the z axis that lies at (rho, z) in it.
inline Vec3d turned_to(const Vec3d& p, double rho, double z) {
    const double at = std::hypot(p.x, p.y);
    return at > 0 ? Vec3d{p.x / at * rho, p.y / at * rho, z} : Vec3d{rho, 0, z};
}

}  // namespace shape_detail

/// z = 0, inside below.
struct PlaneShape {
    template <class T>
    static T value(const Vec3<T>& p) {
        return p.z;
    }
    static Vec3d foot(const Vec3d& p) { return {p.x, p.y, 0}; }
};

struct SphereShape {
    template <class T>
    static T value(const Vec3<T>& p) {
        return norm(p) - 1.0;
    }
    static Vec3d foot(const Vec3d& p) {
        const double r = std::hypot(p.x, p.y, p.z);
        return r > 0 ? p / r : Vec3d{0, 0, 1};
    }
};

struct TorusShape {
    static constexpr double kMajor = 1, kMinor = 0.35;
    template <class T>
    static T value(const Vec3<T>& p) {
        return torus_z(p, kMajor, kMinor);
    }
    static Vec3d foot(const Vec3d& p) {
        const double off = std::hypot(p.x, p.y) - kMajor, r = std::hypot(off, p.z);
        if (!(r > 0)) return shape_detail::turned_to(p, kMajor + kMinor, 0);
        return shape_detail::turned_to(p, kMajor + kMinor * (off / r), kMinor * (p.z / r));
    }
};

struct EllipsoidShape {
    static constexpr Vec3d kAxes{1, 0.7, 0.4};
    template <class T>
    static T value(const Vec3<T>& p) {
        return ellipsoid(p, kAxes);
    }
};

/// Dupin ring cyclide (|p|^2 + b^2 - d^2)^2 = 4 (a x - c d)^2 + 4 b^2 y^2 with b^2 = a^2 - c^2; for
/// c = 0 a torus with radii a and d. With q = |p|^2 + b^2 - 2 root(...), d^2 on the surface and >
/// -m everywhere, sqrt(q + m) grows like a distance.
struct CyclideShape {
    static constexpr double kA = 1, kC = 0.3, kD = 0.5, kSqB = kA * kA - kC * kC;
    static constexpr double kM = kC * kC + 2 * kC * kD + 0.01;
    template <class T>
    static T value(const Vec3<T>& p) {
        using std::sqrt;
        const T root = sqrt(square(T(kA * p.x - kC * kD)) + kSqB * square(p.y));
        const T q = square(p.x) + square(p.y) + square(p.z) + kSqB - 2.0 * root;
        return sqrt(q + kM) - std::sqrt(kD * kD + kM);
    }
};

/// Unit cylinder about z.
struct CylinderShape {
    template <class T>
    static T value(const Vec3<T>& p) {
        return hypot2(p.x, p.y) - 1.0;
    }
    static Vec3d foot(const Vec3d& p) { return shape_detail::turned_to(p, 1, p.z); }
};

/// Apex at (0, 0, 1), radius 1 at z = -1.
struct ConeShape {
    static constexpr double kSlope = 0.5;  ///< radius per height: tangent of the half angle
    template <class T>
    static T value(const Vec3<T>& p) {
        return (hypot2(p.x, p.y) - kSlope * (1.0 - p.z)) / std::sqrt(1 + kSlope * kSlope);
    }
    /// On the line from the apex downwards; the apex where that line falls behind it.
    static Vec3d foot(const Vec3d& p) {
        const double along = (kSlope * std::hypot(p.x, p.y) + (1 - p.z)) / (1 + kSlope * kSlope);
        return along > 0 ? shape_detail::turned_to(p, kSlope * along, 1 - along) : Vec3d{0, 0, 1};
    }
};

/// z = x^3 - 3 x y^2, inside below: a flat umbilic at the origin.
struct MonkeyShape {
    template <class T>
    static T value(const Vec3<T>& p) {
        return p.z - p.x * (square(p.x) - 3.0 * square(p.y));
    }
};

/// r = 1 + 0.1 Y with the real harmonic Y ~ z Im (x + i y)^5 / r^6 scaled to maximum 1.
struct BumpyShape {
    static double amplitude() {  // 0.1 over the maximum of sin(t)^5 cos(t), at cos(t)^2 = 1/6
        static const double a = 0.1 / (std::pow(5.0 / 6, 2.5) * std::sqrt(1.0 / 6));
        return a;
    }
    template <class T>
    static T value(const Vec3<T>& p) {
        const T xx = square(p.x), yy = square(p.y), sq_r = xx + yy + square(p.z);
        const T im5 = p.y * (5.0 * square(xx) - 10.0 * xx * yy + square(yy));
        return norm(p) - 1.0 - amplitude() * p.z * im5 / (sq_r * square(sq_r));
    }
};

}  // namespace slim
