#include "slim/cover/drawn_part.h"

#include "slim/model/rim.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr double kBeyond = 0.03;     // over rho: just outside of what is drawn
constexpr double kOnSheet = 0.3;     // over rho, along the normal
constexpr double kFacesAway = -0.2;  // cosine of normals: what is drawn is another side
constexpr double kAlike = 1e-6;      // over rho: a place on a rim

/// How far a leaf is drawn in direction (u, v) of its tangent plane, over rho.
double drawn_reach(const Surfel& s, double u, double v) {
    double reach = kHitTrim;
    for (const PackedRim packed : {s.rims.first, s.rims.second}) {
        const Rim rim = unpack_rim(packed);
        const double toward = rim.u * u + rim.v * v;
        if (!rim.is_whole() && toward > 0) reach = std::min(reach, rim.reach / toward);
    }
    return reach;
}

}  // namespace

Vec3d place_beyond(const Surfel& s, double u, double v) {
    // the core is a ball, not a disc: drawn towards the middle until it is in it
    double r = drawn_reach(s, u, v);
    const double w = s.polynomial.value(r * u, r * v);
    const double length = std::hypot(r, w);
    if (length > kHitTrim) r *= kHitTrim / length;
    r += kBeyond;
    return s.frame.world_from_local({r * u, r * v, s.polynomial.value(r * u, r * v)});
}

std::vector<Vec3d> drawn_places(const Surfel& s) {
    constexpr int kRings = 4, kMore = 6;  // of a ring than of the one within
    std::vector<Vec3d> out{s.center +
                           s.frame.normal * (s.polynomial.value(0, 0) * s.support_radius)};
    for (int ring = 1; ring <= kRings; ++ring)
        for (int k = 0; k < ring * kMore; ++k) {
            const double angle = 2 * std::numbers::pi * k / (ring * kMore);
            const Vec3d rim = place_beyond(s, std::cos(angle), std::sin(angle));
            // the outermost ring stands just within what place_beyond() is without
            const Vec3d flat = s.frame.local_from_world(rim);
            const double r = std::hypot(flat.x, flat.y) - 2 * kBeyond,
                         share = std::max(0.0, r) * ring / kRings;
            const double u = share * std::cos(angle), v = share * std::sin(angle);
            const Vec3d local{u, v, s.polynomial.value(u, v)};
            out.push_back(s.center + s.frame.world_from_local(local) * s.support_radius);
        }
    return out;
}

bool is_drawn_at(const Surfel& s, const Vec3d& x, const Vec3d& normal) {
    const Vec3d away = x - s.center;
    const double sq = sq_length(away), sq_radius = s.support_radius * s.support_radius;
    if (sq > sq_radius) return false;
    if (s.sharp) return sq < kHitTrim * kHitTrim * sq_radius;
    if (dot(s.frame.normal, normal) < kFacesAway) return false;
    const Vec3d local = s.frame.local_from_world(away / s.support_radius);
    const double w = s.polynomial.value(local.x, local.y);
    if (std::abs(local.z - w) > kOnSheet) return false;
    if (local.x * local.x + local.y * local.y + w * w > kHitTrim * kHitTrim) return false;
    for (const PackedRim packed : {s.rims.first, s.rims.second}) {
        const Rim rim = unpack_rim(packed);
        if (rim.u * local.x + rim.v * local.y > rim.reach + kAlike) return false;
    }
    return true;
}

}  // namespace slim
