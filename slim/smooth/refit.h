#pragma once

#include "slim/smooth/far_fits.h"
#include "slim/smooth/lifted_fits.h"
#include "slim/smooth/wide_radius.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace slim {

/// How far the surface fitted anew may be from the model's own:
/// the larger of 6 of the leaf's noise and 0.25 radii.
double most_off_model(const Surfel& leaf, double noise);

/// Keeps the leaves that take most fits, of equals the last, until a RefittedSurface has no more
/// than `most_fits`: those whose radii are narrowest against the leaf's gain least. Returns how
/// many. In parallel, the same for any thread count.
std::size_t keep_costly_leaves(const BallIndex& model, std::size_t most_fits,
                               std::span<WideRadius> radii);

/// The surface of a model fitted anew to a cloud for the least error of position (notes/0003):
/// quadratics at places a core apart (kCore), each to all points within the radius that wide_radii
/// gives the leaf there and lifted by what its neighbours share (lift_fits), and the leaves that
/// are kept but for strays: those that follow points which the noise of fits around explains. Built
/// once, read by any number of threads; 560 bytes a fit.
class RefittedSurface {
public:
    /// noise, radii: of each leaf, in the index's order; wide_radii gives the latter. In parallel,
    /// the same for any thread count.
    RefittedSurface(const BallIndex& model, std::span<const LeafNoise> noise,
                    std::span<const WideRadius> radii, const PointPyramid& points,
                    const EachBatch& each_batch = {});

    const BallIndex& fits() const { return fits_; }
    std::size_t n_strays() const { return n_strays_; }
    /// Foot of a point that may lie outside all fits' balls, on the nearest fit's surface along the
    /// fit's normal: within 6 of its leaf's noise, and of a fit that does not face away from
    /// `normal` (zero: any). Nothing if there is none.
    std::optional<Vec3d> foot(const Vec3d& p, const Vec3d& normal) const;

    /// Number of the model's leaf that a fit is, or was fitted in; the fit by its number in fits().
    std::uint32_t leaf_of(std::size_t fit) const { return leaf_[fits_.node(fit)]; }

    /// most_off_model() of the leaf of a fit.
    double off(std::size_t fit) const { return off_[leaf_of(fit)]; }

    /// The largest most_off_model() of leaves of the model, and the least of the leaves of fits.
    double most_off(const std::vector<const Surfel*>& leaves) const;
    double least_off(const std::vector<const Surfel*>& fits) const;

private:
    struct Fits {
        std::vector<Surfel> near;
        FarFits far;
        std::vector<std::uint32_t> leaf;  // of each of near: that it is, or was fitted in
        std::size_t n_strays = 0;
    };
    static Fits together(const BallIndex& model, std::span<const LeafNoise> noise,
                         std::span<const WideRadius> radii, const PointPyramid& points,
                         std::vector<std::vector<PlacedFit>>& fitted);
    static Fits fit(const BallIndex& model, std::span<const LeafNoise> noise,
                    std::span<const WideRadius> radii, const PointPyramid& points,
                    const EachBatch& each_batch = {});
    RefittedSurface(const BallIndex& model, std::span<const LeafNoise> noise, Fits fits);
    const BallIndex& model_;  // must outlive this
    std::vector<double> off_;  // of the model's leaves
    std::vector<std::uint32_t> leaf_;  // as Fits has them
    BallIndex fits_;
    FarFits far_;
    std::size_t n_strays_ = 0;
};

}  // namespace slim
