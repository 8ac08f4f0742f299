#pragma once

#include "slim/base/frame.h"
#include "slim/model/surfel.h"
#include "tests/raytrace/support/analytic_models.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

namespace slim::test {

inline Sheet plane_sheet(const Vec3d& normal) {
    return {frame_from_normal(round_normal(normalized(normal))), {}};
}

inline Surfel plane_surfel(const Vec3d& center, const Vec3d& normal, double rho) {
    return {center, rho, plane_sheet(normal).frame, {}, 2};
}

/// Two planes through the centre.
inline Surfel edge_surfel(const Vec3d& center, const Vec3d& a, const Vec3d& b, double rho,
                          Join how = Join::max) {
    Surfel s = plane_surfel(center, a, rho);
    auto more = std::make_shared<SharpSheets>();
    more->extra[0] = plane_sheet(b), more->outer = how;
    s.sharp = more;
    return s;
}

/// Three planes through the centre: outer(a, inner(b, c)).
inline Surfel corner_surfel(const Vec3d& center, const std::array<Vec3d, 3>& n, double rho,
                            Join outer = Join::max, Join inner = Join::max) {
    Surfel s = edge_surfel(center, n[0], n[1], rho, outer);
    auto more = std::make_shared<SharpSheets>(*s.sharp);
    more->extra[1] = plane_sheet(n[2]), more->n_extra = 2, more->inner = inner;
    s.sharp = more;
    return s;
}

inline Vec3d axis_vector(std::size_t axis, double sign) {
    Vec3d v;
    v[axis] = sign;
    return v;
}

/// The cube [-1, 1]^3: a leaf of three sheets at each corner, leaves of two along the edges, smooth
/// ones on the faces that end before the edges.
inline std::vector<Surfel> cube_leaves() {
    constexpr double kAlong[] = {-0.7, -0.4, -0.1, 0.2, 0.5, 0.75};
    std::vector<Surfel> out;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0})
                out.push_back(corner_surfel({x, y, z},
                                            {Vec3d{x, 0, 0}, Vec3d{0, y, 0}, Vec3d{0, 0, z}}, 0.5));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (const double a : {-1.0, 1.0}) {
            for (const double b : {-1.0, 1.0})
                for (const double t : kAlong) {
                    const Vec3d center =
                        axis_vector(axis, t) + axis_vector(u, a) + axis_vector(v, b);
                    out.push_back(edge_surfel(center, axis_vector(u, a), axis_vector(v, b), 0.4));
                }
            for (const double s : {-0.6, -0.3, 0.0, 0.3, 0.6})
                for (const double t : {-0.6, -0.3, 0.0, 0.3, 0.6})
                    out.push_back(
                        plane_surfel(axis_vector(axis, a) + axis_vector(u, s) + axis_vector(v, t),
                                     axis_vector(axis, a), 0.39));
        }
    }
    return out;
}

/// The rim of a cylinder of radius 1 about z, cut off by z < 0: n leaves of a plane and a quadric,
/// and the faces about it.
inline std::vector<Surfel> rim_leaves(int n, double rho) {
    std::vector<Surfel> out;
    for (int i = 0; i < n; ++i) {
        const double a = 2 * std::numbers::pi * i / n;
        const Vec3d outwards{std::cos(a), std::sin(a), 0};
        Surfel s = edge_surfel(outwards, {0, 0, 1}, outwards, rho);
        auto more = std::make_shared<SharpSheets>(*s.sharp);
        // w = -rho t^2 / 2 along the circle's tangent t, over rho.
        const Frame<double>& f = more->extra[0].frame;
        const double tu = -std::sin(a) * f.u_axis.x + std::cos(a) * f.u_axis.y;
        const double tv = -std::sin(a) * f.v_axis.x + std::cos(a) * f.v_axis.y;
        auto& c = more->extra[0].polynomial.a;
        c[3] = -0.5 * rho * tu * tu, c[4] = -rho * tu * tv, c[5] = -0.5 * rho * tv * tv;
        s.sharp = more;
        out.push_back(s);
    }
    return out;
}

}  // namespace slim::test
