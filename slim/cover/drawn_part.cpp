#include "slim/cover/drawn_part.h"

#include "slim/model/rim.h"

#include <algorithm>
#include <cmath>

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
