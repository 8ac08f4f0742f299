#include "slim/fit/parallel_sheet.h"

#include "slim/fit/radius_ladder.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr double kExplained = 3;       // times what noise and price explain
constexpr double kLeastPoints = 24;    // of a sheet, to say that it fills the disc
constexpr double kByChance = 0.3;      // of a single point's lean, standard deviation
constexpr double kSurely = 3;          // standard deviations

/// How many of those set aside lie off the fit and face sideways, not the other way.
template <class T>
std::size_t count_sideways(const BallPoints<T>& p, std::span<const SetAside<T>> aside,
                           const SheetFit& sheet) {
    const Vec3f up = to_float(sheet.frame.normal);
    std::vector<SetAside<T>> sideways;
    for (const SetAside<T>& a : aside)
        if (dot(up, Vec3f{p.nx[a.index], p.ny[a.index], p.nz[a.index]}) >= kOtherSideCos)
            sideways.push_back(a);
    return count_off_sheet<T>(p, sideways, sheet.frame, sheet.fit, sheet.tolerance);
}

/// Weighted mean of the points in the tangent plane, over rho, and what chance makes of it. Under
/// G: where a sheet ends farther out, rims end the leaf (slim/cover/notes/0007).
struct Balance {
    double lean, by_chance;
};

template <class T>
Balance balance_of(const BallPoints<T>& p, const Frame<double>& frame) {
    double weight = 0, sq_weight = 0, u = 0, v = 0;
    for (std::size_t i = 0; i < p.n; ++i) {
        const double g = weight_kernel(static_cast<double>(p.sq[i]));
        const Vec3d x{p.x[i], p.y[i], p.z[i]};
        weight += g, sq_weight += g * g;
        u += g * dot(x, frame.u_axis), v += g * dot(x, frame.v_axis);
    }
    if (!(weight > 0)) return {1, 0};
    return {std::hypot(u, v) / weight, kByChance * std::sqrt(sq_weight) / weight};
}

}  // namespace

template <class T>
SheetEnd end_of_sheet(const BallPoints<T>& p, std::span<const SetAside<T>> aside,
                      const SheetFit& sheet) {
    const LocalFit& fit = sheet.fit;
    const double freedom = std::max(fit.n_effective - n_coefficients(fit.degree), 0.5);
    const double over = fit.sq_error / (kExplained * sheet.sq_explained);
    if (!(over <= 1 + kSurely * std::sqrt(2 / freedom))) return SheetEnd::ends;
    if (!within_noise(count_sideways(p, aside, sheet), p.n, sheet.contrary_share))
        return SheetEnd::ends;
    const Balance at = balance_of(p, sheet.frame);
    if (at.lean > sheet.most_lean + kSurely * at.by_chance) return SheetEnd::ends;
    const bool is_sure = over <= 1 && static_cast<double>(p.n - aside.size()) >= kLeastPoints &&
                         at.lean <= sheet.most_lean + at.by_chance;
    return is_sure ? SheetEnd::goes_on : SheetEnd::in_doubt;
}

template SheetEnd end_of_sheet(const BallPoints<float>&, std::span<const SetAside<float>>,
                               const SheetFit&);
template SheetEnd end_of_sheet(const BallPoints<double>&, std::span<const SetAside<double>>,
                               const SheetFit&);

}  // namespace slim
