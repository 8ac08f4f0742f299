#include "slim/smooth/refit.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/model/weight_kernel.h"
#include "slim/smooth/wide_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace slim {
namespace {

const double kBlend = 2 * kCore;  ///< of a fit's radius: how far it is blended
constexpr double kReach = 6;          ///< of the noise: points so far off still have a foot
constexpr double kOffNoises = 6, kOffRadii = 0.25;  ///< a fit's surface this far off the model is another sheet's
constexpr int kMostMoves = 3;        ///< of a place onto the fit about it
constexpr double kMostSpread = 30;    ///< of WideFit::spread

/// Whether a leaf is the one that weighs most at a place, of equals the first.
bool owns(const BallIndex& model, std::size_t leaf, const Vec3d& place, std::vector<const Surfel*>& found) {
    model.supporters(place, found);
    const auto weight = [&](const Surfel& s) {
        return weight_kernel(sq_length(place - s.center) / (s.support_radius * s.support_radius));
    };
    const Surfel* most = nullptr;
    for (const Surfel* s : found)
        if (!most || weight(*s) > weight(*most)) most = s;
    return most == &model.leaf(leaf);
}

/// A quadratic of coordinates over `from` in coordinates over `to`.
Polynomial<double> rescaled(const Polynomial<double>& p, double ratio) {
    Polynomial<double> out;
    out.a[0] = p.a[0] / ratio;
    for (std::size_t k = 1; k < 3; ++k) out.a[k] = p.a[k];
    for (std::size_t k = 3; k < 6; ++k) out.a[k] = p.a[k] * ratio;
    return out;
}

void fit_place(Vec3d place, const Vec3d& normal, double radius, double noise, double most_off,
               const PointPyramid& points, WideWork& work, std::vector<Surfel>& out) {
    const Vec3d on_model = place;
    Frame<double> frame = frame_from_normal(normal);
    auto fit = fit_wide(points.all(), place, frame, radius, noise, false, work);
    for (int i = 0; i < kMostMoves && fit && put_on(*fit, radius, noise, place, frame); ++i)
        fit = fit_wide(points.all(), place, frame, radius, noise, false, work);
    if (!fit || !(fit->spread <= kMostSpread)) return;
    const double height = fit->polynomial.a[0] * radius;
    if (!(length(place + frame.normal * height - on_model) <= most_off)) return;
    out.push_back({place, kBlend * radius, frame, rescaled(fit->polynomial, kBlend), 2});
}

/// Calls body(place, normal) for the places of a triangular grid on the leaf's surface that it owns.
template <class Body>
void for_places(const BallIndex& model, std::size_t leaf, double radius, std::vector<const Surfel*>& found,
                const Body& body) {
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

}  // namespace

double most_off_model(const Surfel& leaf, double noise) {
    return std::max(kOffNoises * noise, kOffRadii * leaf.support_radius);
}

std::size_t keep_costly_leaves(const BallIndex& model, std::size_t most_fits, std::span<WideRadius> radii) {
    SLIM_CHECK(radii.size(), ==, model.n_leaves());
    std::vector<std::uint32_t> count(radii.size());
    parallel_blocks(radii.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end; ++i)
            if (radii[i].radius > 0)
                for_places(model, i, radii[i].radius, found, [&](const Vec3d&, const Vec3d&) { ++count[i]; });
    });
    std::vector<std::uint32_t> order(radii.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return count[a] < count[b]; });
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

RefittedSurface::RefittedSurface(const BallIndex& model, std::span<const LeafNoise> noise, Fits fits)
    : model_(model), leaf_(std::move(fits.leaf)), fits_(std::move(fits.near)), far_(std::move(fits.far)) {
    off_.reserve(noise.size());
    for (std::size_t i = 0; i < noise.size(); ++i) off_.push_back(most_off_model(model.leaf(i), noise[i].fit_error));
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
                                           std::span<const WideRadius> radii, const PointPyramid& points,
                                           const EachBatch& each_batch) {
    SLIM_CHECK(noise.size(), ==, model.n_leaves());
    SLIM_CHECK(radii.size(), ==, model.n_leaves());
    std::vector<std::vector<Surfel>> fitted(radii.size());
    parallel_batches(radii.size(), 4, each_batch, [&](std::size_t begin, std::size_t end) {
        WideWork work;
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end; ++i)
            if (radii[i].radius > 0)
                for_places(model, i, radii[i].radius, found, [&](const Vec3d& place, const Vec3d& normal) {
                    fit_place(place, normal, radii[i].radius, noise[i].fit_error,
                              most_off_model(model.leaf(i), noise[i].fit_error), points, work, fitted[i]);
                });
    });
    Fits out;
    for (std::size_t i = 0; i < fitted.size(); ++i) {
        if (!(radii[i].radius > 0)) {
            out.near.push_back(model.leaf(i));
            out.leaf.push_back(static_cast<std::uint32_t>(i));
        }
        for (const Surfel& s : fitted[i]) {
            const double reach = std::hypot(s.support_radius, kReach * noise[i].fit_error);
            out.far.push_back({s.center, reach, s.frame, rescaled(s.polynomial, reach / s.support_radius), 2});
            out.near.push_back(s);
            out.leaf.push_back(static_cast<std::uint32_t>(i));
        }
        fitted[i] = {};
    }
    return out;
}

std::optional<Vec3d> RefittedSurface::foot(const Vec3d& p, const Vec3d& normal) const {
    std::vector<const Surfel*> found;
    far_.supporters(p, found);
    const Surfel* nearest = nullptr;
    double least = INFINITY;
    for (const Surfel* s : found) {
        const double sq = sq_length(p - s->center);
        if (sq < least && dot(s->frame.normal, normal) >= 0) least = sq, nearest = s;
    }
    if (!nearest) return std::nullopt;
    const double above = nearest->value((p - nearest->center) / nearest->support_radius);
    return p - nearest->frame.normal * (above * nearest->support_radius);
}

}  // namespace slim
