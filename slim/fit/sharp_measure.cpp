#include "slim/fit/sharp_measure.h"

#include "slim/fit/ball_normal.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr double kOffSheet = 5;       // times the noise, as in the ladder
constexpr double kLeastShare = 0.25;  // of 1 - K / n_eff, as in LocalFit

/// Points that lie off the joined surface, or off the sheet whose normal they have: a mean over the
/// ball would hide the few points of a third face, and sheets where there is no surface at all.
/// error, noise: over the radius
template <class T>
std::size_t count_off(const BallPoints<T>& points, double error, double noise,
                      const FittedSheets& sheets, const SharpWork<T>& work) {
    const double tolerance = kExplained * std::max(error, noise);
    std::size_t n = 0;
    for (std::size_t i = 0; i < points.n; ++i) {
        const auto& at = work.beside[i];
        const double f = std::abs(at.height);
        if (at.cosine < kLeastCos)
            n += f > kOffSheet * noise;
        else
            n += f > tolerance || std::abs(sheets.value(at.sheet, points.place(i))) > tolerance;
    }
    return n;
}

}  // namespace

template <class T>
void measure_sharp(const BallPoints<T>& points, double noise, FittedSheets& sheets,
                   SharpWork<T>& work) {
    SharpFit& fit = sheets.fit;
    const Surfel joined = fit.surfel({}, 1);
    if (work.beside.size() < points.n) work.beside.resize(2 * points.n);
    double rss = 0, weight = 0, sq_weight = 0;
    for (std::size_t i = 0; i < points.n; ++i) {
        const Vec3d x = points.place(i);
        const double f = joined.value(x);
        const auto [sheet, cosine] = sheets.nearest_normal(x, points.normal(i));
        work.beside[i] = {f, cosine, sheet};
        if (cosine < kLeastCos) continue;
        const double g = static_cast<double>(fit_weight(points.weight, points.sq[i]));
        rss += g * f * f;
        weight += g;
        sq_weight += g * g;
    }
    fit.n_points = points.n;
    fit.n_effective = sq_weight > 0 ? weight * weight / sq_weight : 0;
    const double freedom = 1 - fit.n_coefficients / std::max(fit.n_effective, 1.0);
    const double sq_error = weight > 0 ? rss / weight / std::max(freedom, kLeastShare) : INFINITY;
    fit.sq_error = points.radius * points.radius * sq_error;
    fit.n_off = count_off(points, std::sqrt(sq_error), noise, sheets, work);
}

template void measure_sharp(const BallPoints<float>&, double, FittedSheets&, SharpWork<float>&);
template void measure_sharp(const BallPoints<double>&, double, FittedSheets&, SharpWork<double>&);

}  // namespace slim
