#include "slim/smooth/point_projector.h"

namespace slim {

std::optional<Projection> PointProjector::along(const Vec3d& p, const Vec3d& n,
                                                bool want_curvature) const {
    std::optional<Projection> hit = project_along(p, n, found_, want_curvature);
    if (hit && dot(hit->normal, n) < least_cosine_) hit.reset();
    return hit;
}

ProjectedPoint PointProjector::project(const Vec3d& p, const Vec3d& own_normal,
                                       bool want_curvature) {
    ProjectedPoint out;
    index_.supporters(p, found_);
    out.has_normal = is_finite(own_normal) && sq_length(own_normal) > 0;
    out.direction =
        out.has_normal ? normalized(own_normal) : normal_at(p, found_).value_or(Vec3d{});
    if (!(sq_length(out.direction) > 0)) return out;
    out.hit = along(p, out.direction, want_curvature);
    if (out.hit) return out;
    out.hit = along(p, -out.direction, want_curvature);
    out.opposed = out.hit.has_value();
    if (out.hit) return out;
    // As scans have at depth edges: a supported point whose normal runs along the surface.
    if (const std::optional<Vec3d> n = normal_at(p, found_))
        out.hit = project_along(p, *n, found_, want_curvature);
    out.astray = out.hit.has_value();
    return out;
}

}  // namespace slim
