#pragma once

#include "slim/smooth/leaf_lanes.h"
#include "slim/smooth/point_projector.h"
#include "slim/smooth/smoothing.h"

#include <optional>

namespace slim {

/// Where a point of a cloud goes.
struct SurfacePut {
    Vec3d point, normal;  ///< the latter unit, outwards; zero: it has no place there
    bool opposed = false, astray = false;  ///< as PointProjector says
};

/// Puts points on the fits made anew; those out of their reach by way of the nearest fit's foot, or
/// of the model. Where that ends farther from the model's own projection than fits may be from the
/// model, the latter counts. One a thread.
class SurfaceProjector {
public:
    explicit SurfaceProjector(const SmoothSurface& surface);

    /// Makes ready for points of a box that are asked next, by project_gathered().
    void gather(const Bbox& box);
    /// How many surfels are about the box.
    std::size_t n_gathered() const { return lanes_.numbers().size(); }

    SurfacePut project(const Vec3d& p, const Vec3d& normal);
    /// The same, but for the last bits, for a point of the box: by lanes where nothing is amiss.
    SurfacePut project_gathered(const Vec3d& p, const Vec3d& normal);

    /// Whether the last point was put on the model's own surface instead of the fits.
    bool by_model() const { return surface_ && by_model_; }
    /// How much of the way that was found last, of a length, the surface is to be trusted with: by
    /// the surfels that were asked, where they were.
    double share(double distance) const;

private:
    std::optional<SurfacePut> by_lanes(const Vec3d& p, const Vec3d& normal);
    ProjectedPoint on_surface(const Vec3d& p, const Vec3d& normal);
    ProjectedPoint by_foot(const Vec3d& p, const Vec3d& normal, const Vec3d& facing);
    ProjectedPoint on_fits(const Vec3d& p, const Vec3d& normal);
    double least_off_of_lanes() const;

    PointProjector model_;
    const RefittedSurface* surface_;
    const BallIndex& index_;
    const BallIndex& first_;  // that is asked first: of the fits or the model
    std::span<const LeafTrust> trust_;
    std::optional<PointProjector> fits_;
    LeafLanes lanes_;
    bool by_model_ = false, by_lanes_ = false;
    Vec3d asked_at_;  // where the model, or the fits, were asked last
};

}  // namespace slim
