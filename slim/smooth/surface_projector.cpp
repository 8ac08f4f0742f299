#include "slim/smooth/surface_projector.h"

#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

SurfacePut put_of(const ProjectedPoint& p) {
    if (!p.hit) return {};
    return {p.hit->point, p.hit->normal, p.opposed, p.astray};
}

}  // namespace

SurfaceProjector::SurfaceProjector(const SmoothSurface& surface)
    : model_(surface.model, kTrustedCosine),
      surface_(surface.refitted),
      index_(surface.model),
      first_(surface.refitted ? surface.refitted->fits() : surface.model),
      trust_(surface.trust) {
    if (surface_) fits_.emplace(surface_->fits(), kTrustedCosine);
}

void SurfaceProjector::gather(const Bbox& box) { lanes_.gather(first_, box); }

SurfacePut SurfaceProjector::project(const Vec3d& p, const Vec3d& normal) {
    by_lanes_ = false;
    return put_of(on_surface(p, normal));
}

SurfacePut SurfaceProjector::project_gathered(const Vec3d& p, const Vec3d& normal) {
    if (const auto put = by_lanes(p, normal)) return *put;
    return project(p, normal);
}

std::optional<SurfacePut> SurfaceProjector::by_lanes(const Vec3d& p, const Vec3d& normal) {
    if (!lanes_.are_plain()) return std::nullopt;
    const bool has_normal = is_finite(normal) && sq_length(normal) > 0;
    const Vec3d along = has_normal ? normalized(normal) : lanes_.normal_at(p).value_or(Vec3d{});
    if (!(sq_length(along) > 0)) return std::nullopt;
    const auto put = lanes_.project_along(p, along);
    if (!put || dot(put->normal, along) < kTrustedCosine) return std::nullopt;
    if (surface_ && length(put->point - p) > least_off_of_lanes()) return std::nullopt;
    by_lanes_ = true, by_model_ = false;
    return SurfacePut{put->point, put->normal};
}

double SurfaceProjector::least_off_of_lanes() const {
    double least = INFINITY;
    lanes_.for_supporters(
        [&](std::uint32_t fit, double) { least = std::min(least, surface_->off(fit)); });
    return least;
}

ProjectedPoint SurfaceProjector::on_surface(const Vec3d& p, const Vec3d& normal) {
    asked_at_ = p, by_model_ = !surface_;
    if (!surface_) return model_.project(p, normal);
    const ProjectedPoint put = on_fits(p, normal);
    if (!put.hit || by_model_ ||
        length(put.hit->point - p) <= surface_->least_off(fits_->supporters()))
        return put;
    ProjectedPoint own = model_.project(p, normal);
    if (!own.hit) return put;
    const double off = length(put.hit->point - own.hit->point);
    if (off <= surface_->most_off(model_.supporters())) return put;
    asked_at_ = p, by_model_ = true;
    return own;
}

ProjectedPoint SurfaceProjector::by_foot(const Vec3d& p, const Vec3d& normal, const Vec3d& facing) {
    const auto foot = surface_->foot(p, facing);
    if (!foot) return {};
    asked_at_ = *foot;
    return fits_->project(*foot, normal);
}

ProjectedPoint SurfaceProjector::on_fits(const Vec3d& p, const Vec3d& normal) {
    const Vec3d facing = is_finite(normal) ? normal : Vec3d{};
    ProjectedPoint put = fits_->project(p, normal);
    if (!put.hit) put = by_foot(p, normal, facing);
    // A normal contrary to all fits in reach says as little as that of a point in their balls. A
    // sheet that it agrees with has fits, or leaves among them that are kept; what the model has
    // there beside is strays.
    if (!put.hit && sq_length(facing) > 0) put = by_foot(p, normal, {});
    if (put.hit) return put;
    put = model_.project(p, normal);
    asked_at_ = p, by_model_ = true;
    if (!put.hit) return put;
    const auto again = fits_->project(put.hit->point, put.hit->normal);
    if (!again.hit) return put;
    asked_at_ = put.hit->point, by_model_ = false;
    put.hit = again.hit;
    return put;
}

double SurfaceProjector::share(double distance) const {
    if (trust_.empty()) return 1;
    PointTrust trust(distance);
    const auto leaf_of = [&](std::size_t first) {
        return surface_ ? surface_->leaf_of(first) : first;
    };
    if (by_lanes_) {
        lanes_.for_supporters(
            [&](std::uint32_t i, double weight) { trust.add(trust_[leaf_of(i)], weight); });
        return trust.share();
    }
    for (const Surfel* s : (by_model_ ? model_ : *fits_).supporters()) {
        const std::size_t leaf =
            by_model_ ? index_.number_of(s) : leaf_of(surface_->fits().number_of(s));
        trust.add(trust_[leaf], weight_kernel(sq_length(asked_at_ - s->center) /
                                              (s->support_radius * s->support_radius)));
    }
    return trust.share();
}

}  // namespace slim
