#include "slim/smooth/point_projector.h"

#include "slim/blend/sheet_normals.h"

#include <cmath>

namespace slim {

std::optional<Projection> PointProjector::along(const Vec3d& p, const Vec3d& n,
                                                bool want_curvature) const {
    std::optional<Projection> hit = project_along(p, n, found_, want_curvature);
    if (hit && dot(hit->normal, n) < least_cosine_) hit.reset();
    return hit;
}

void PointProjector::put_on_nearest_sheet(const Vec3d& p, bool want_curvature,
                                          ProjectedPoint& out) const {
    const std::optional<SheetNormals> sheets = sheet_normals_at(p, found_);
    if (!sheets) return;
    out.direction = sheets->first;
    const auto try_along = [&](const Vec3d& n) {
        const std::optional<Projection> hit = along(p, n, want_curvature);
        if (!hit || (out.hit && std::abs(out.hit->t) <= std::abs(hit->t))) return;
        out.hit = hit, out.direction = n;
    };
    try_along(sheets->first);
    if (sq_length(sheets->second) > 0) try_along(sheets->second);
    if (!out.hit) try_along(-sheets->first);
    if (out.hit) return;
    out.hit = project_along(p, sheets->first, found_, want_curvature);
    out.astray = out.hit.has_value();
}

ProjectedPoint PointProjector::project(const Vec3d& p, const Vec3d& own_normal,
                                       bool want_curvature) {
    ProjectedPoint out;
    index_.supporters(p, found_);
    out.has_normal = is_finite(own_normal) && sq_length(own_normal) > 0;
    if (!out.has_normal) {
        put_on_nearest_sheet(p, want_curvature, out);
        return out;
    }
    out.direction = normalized(own_normal);
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
