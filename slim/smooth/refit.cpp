#include "slim/smooth/refit.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/model/weight_kernel.h"
#include "slim/smooth/lifted_fits.h"
#include "slim/smooth/wide_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace slim {
namespace {

const double kBlend = 2 * kCore;  ///< of a fit's radius: how far it is blended
constexpr double kReach = 6;          ///< of the noise: points so far off still have a foot
constexpr double kOffNoises = 6, kOffRadii = 0.25;  ///< a fit's surface this far off
                                                    ///< the model is another sheet's
constexpr int kMostMoves = 3;        ///< of a place onto the fit about it
constexpr double kMostSpread = 30;    ///< of WideFit::spread
constexpr double kFewPoints = 60, kStrayShare = 0.25;  ///< of a stray's own points,
                                                       ///< and of those there
constexpr double kContraryShare = 0.05;
constexpr float kAnyNormal = -2;

/// Whether a leaf is the one that weighs most at a place, of equals the first.
bool owns(const BallIndex& model, std::size_t leaf, const Vec3d& place,
          std::vector<const Surfel*>& found) {
    model.supporters(place, found);
    const auto weight = [&](const Surfel& s) {
        return weight_kernel(sq_length(place - s.center) / (s.support_radius * s.support_radius));
    };
    const Surfel* most = nullptr;
    for (const Surfel* s : found)
        if (!most || weight(*s) > weight(*most)) most = s;
    return most == &model.leaf(leaf);
}

/// Where a leaf's fits are made, and from what.
struct FitPlaces {
    const PointPyramid& points;
    double radius, noise, curvature, most_off;
};

void fit_place(const Vec3d& place, const Vec3d& normal, const FitPlaces& of, WideWork& work,
               std::vector<PlacedFit>& out) {
    WideDisc disc{place, frame_from_normal(normal), of.radius, of.noise, of.curvature};
    const auto fit_disc = [&] {
        auto fit = fit_wide(of.points.all(), disc, true, work);
        return fit ? fit : fit_wide(of.points.all(), disc, false, work);
    };
    auto fit = fit_disc();
    for (int i = 0; i < kMostMoves && fit && put_on(*fit, disc); ++i) fit = fit_disc();
    if (!fit || !(fit->spread <= kMostSpread)) return;
    const double height = fit->polynomial.a[0] * of.radius;
    if (!(length(disc.center + disc.frame.normal * height - place) <= of.most_off)) return;
    out.push_back(
        {{disc.center, kBlend * of.radius, disc.frame, rescaled(fit->polynomial, kBlend), 2},
         of.radius,
         fit->lift,
         fit->sq_lift_error,
         height_by_noise_of_feet(*fit, of.radius),
         fit->turn,
         fit->sq_turn_error});
}

/// Calls body(place, normal) for the places of a triangular grid on the leaf's surface that it
/// owns.
template <class Body>
void for_places(const BallIndex& model, std::size_t leaf, double radius,
                std::vector<const Surfel*>& found, const Body& body) {
    const Surfel& s = model.leaf(leaf);
    const double step = kCore * radius / s.support_radius, row = step * std::numbers::sqrt3 / 2;
    const int rows = static_cast<int>(1 / row), columns = static_cast<int>(1 / step) + 1;
    for (int j = -rows; j <= rows; ++j)
        for (int i = -columns; i <= columns; ++i) {
            const double u = (i + (j % 2 != 0 ? 0.5 : 0.0)) * step, v = j * row;
            if (!(u * u + v * v < 1)) continue;
            const Vec3d local{u, v, s.polynomial.value(u, v)};
            const Vec3d place = s.center + s.frame.world_from_local(local) * s.support_radius;
            if (!owns(model, leaf, place, found)) continue;
            const Vec3d gradient{-s.polynomial.d_u(u, v), -s.polynomial.d_v(u, v), 1};
            body(place, normalized(s.frame.world_from_local(gradient)));
        }
}

/// Points about a foot within a leaf's radius, out to what noise explains, that face as `normal`
/// does within a cosine.
double count_about(const FarFits::Foot& foot, const Vec3d& normal, float least_cos, double radius,
                   const PointPyramid& points, WideWork& work) {
    gather_disc(points.all(), foot.point, normal, radius, std::hypot(radius, foot.off), least_cos,
                work.ball);
    return static_cast<double>(work.ball.n);
}

/// Whether what a leaf of few points follows is the noise of a fit that was made anew: it lies in
/// it, and holds few of the points there; or faces the other way, as hardly any of them do.
bool is_stray(const Surfel& leaf, double n_points, const FarFits& far, const PointPyramid& points,
              WideWork& work) {
    if (!(n_points < kFewPoints)) return false;
    const double radius = leaf.support_radius;
    auto foot = far.foot(leaf.center, leaf.frame.normal);
    const bool is_facing = foot.has_value();
    if (!is_facing) foot = far.foot(leaf.center, {});
    if (!foot || length(leaf.center - foot->point) > foot->off) return false;
    if (is_facing)
        return n_points * points.share(0) <
               kStrayShare * count_about(*foot, foot->normal, 0, radius, points, work);
    const double facing_away = count_about(*foot, -foot->normal, 0, radius, points, work);
    return facing_away <
           kContraryShare * count_about(*foot, foot->normal, kAnyNormal, radius, points, work);
}

}  // namespace

double most_off_model(const Surfel& leaf, double noise) {
    return std::max(kOffNoises * noise, kOffRadii * leaf.support_radius);
}

std::size_t keep_costly_leaves(const BallIndex& model, std::size_t most_fits,
                               std::span<WideRadius> radii) {
    SLIM_CHECK(radii.size(), ==, model.n_leaves());
    std::vector<std::uint32_t> count(radii.size());
    parallel_blocks(radii.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end; ++i)
            if (radii[i].radius > 0)
                for_places(model, i, radii[i].radius, found,
                           [&](const Vec3d&, const Vec3d&) { ++count[i]; });
    });
    std::vector<std::uint32_t> order(radii.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return count[a] < count[b]; });
    std::size_t n_fits = 0, n_kept = 0;
    for (const std::uint32_t i : order) {
        n_fits += count[i];
        if (n_fits <= most_fits || !(radii[i].radius > 0)) continue;
        radii[i].radius = radii[i].sq_noise = 0;
        ++n_kept;
    }
    return n_kept;
}

RefittedSurface::RefittedSurface(const BallIndex& model, std::span<const LeafNoise> noise,
                                 std::span<const WideRadius> radii, const PointPyramid& points,
                                 const EachBatch& each_batch)
    : RefittedSurface(model, noise, fit(model, noise, radii, points, each_batch)) {}

RefittedSurface::RefittedSurface(const BallIndex& model, std::span<const LeafNoise> noise,
                                 Fits fits)
    : model_(model),
      leaf_(std::move(fits.leaf)),
      fits_(std::move(fits.near)),
      far_(std::move(fits.far)),
      n_strays_(fits.n_strays) {
    off_.reserve(noise.size());
    for (std::size_t i = 0; i < noise.size(); ++i)
        off_.push_back(most_off_model(model.leaf(i), noise[i].fit_error));
}

double RefittedSurface::most_off(const std::vector<const Surfel*>& leaves) const {
    double most = 0;
    for (const Surfel* s : leaves) most = std::max(most, off_[model_.number_of(s)]);
    return most;
}

double RefittedSurface::least_off(const std::vector<const Surfel*>& fits) const {
    double least = INFINITY;
    for (const Surfel* s : fits) least = std::min(least, off(fits_.number_of(s)));
    return least;
}

RefittedSurface::Fits RefittedSurface::fit(const BallIndex& model, std::span<const LeafNoise> noise,
                                           std::span<const WideRadius> radii,
                                           const PointPyramid& points,
                                           const EachBatch& each_batch) {
    SLIM_CHECK(noise.size(), ==, model.n_leaves());
    SLIM_CHECK(radii.size(), ==, model.n_leaves());
    std::vector<std::vector<PlacedFit>> fitted(radii.size());
    parallel_batches(radii.size(), 4, each_batch, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end; ++i) {
            if (!(radii[i].radius > 0)) continue;
            const Surfel& leaf = model.leaf(i);
            const FitPlaces of{points, radii[i].radius, noise[i].fit_error,
                               largest_curvature(leaf.polynomial, leaf.support_radius),
                               most_off_model(leaf, noise[i].fit_error)};
            for_places(model, i, radii[i].radius, found,
                       [&](const Vec3d& place, const Vec3d& normal) {
                           fit_place(place, normal, of, work, fitted[i]);
                       });
        }
    });
    lift_fits(fitted);
    return together(model, noise, radii, points, fitted);
}

RefittedSurface::Fits RefittedSurface::together(const BallIndex& model,
                                                std::span<const LeafNoise> noise,
                                                std::span<const WideRadius> radii,
                                                const PointPyramid& points,
                                                std::vector<std::vector<PlacedFit>>& fitted) {
    std::vector<FarFit> far;
    for (std::size_t i = 0; i < fitted.size(); ++i)
        for (const PlacedFit& f : fitted[i])
            far.push_back(
                {f.surfel, kReach * std::max(noise[i].fit_error, std::sqrt(radii[i].sq_noise))});
    Fits out{{}, FarFits(far), {}, 0};
    std::vector<std::uint8_t> stray(radii.size());
    parallel_blocks(radii.size(), 64, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        for (std::size_t i = begin; i < end; ++i)
            if (!(radii[i].radius > 0) &&
                is_stray(model.leaf(i), noise[i].n_points, out.far, points, work))
                stray[i] = 1;
    });
    const auto add = [&](const Surfel& s, std::size_t leaf) {
        out.near.push_back(s);
        out.leaf.push_back(static_cast<std::uint32_t>(leaf));
    };
    for (std::size_t i = 0; i < fitted.size(); ++i) {
        if (stray[i] != 0)
            ++out.n_strays;
        else if (!(radii[i].radius > 0))
            add(model.leaf(i), i);
        for (const PlacedFit& f : fitted[i]) add(f.surfel, i);
        fitted[i] = {};
    }
    return out;
}

std::optional<Vec3d> RefittedSurface::foot(const Vec3d& p, const Vec3d& normal) const {
    const auto found = far_.foot(p, normal);
    return found ? std::optional(found->point) : std::nullopt;
}

}  // namespace slim
