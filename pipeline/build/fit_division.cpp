#include "pipeline/build/fit_division.h"

#include "slim/cover/cover_rules.h"
#include "slim/slicing/block_plan.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kFinestLevel = 40;
/// Radii, in spacings of the sample: of the smallest leaf that is kept (8 times the finest ball's
/// 3.3), and of the last level that can still find one where the sample is 2.6 times as dense as
/// usual.
constexpr double kResolved = 26, kLastResolved = 10;

constexpr double kFewestSampled = 20000;
constexpr double kNarrowestHalo = 12;  // spacings: leaves of 450 points

double sample_spacing(const SlicePlan& plan, double share) {
    return plan.spacing / std::sqrt(share);
}

/// With the narrowest halo that suffices.
FitDivision division_for(const SlicePlan& plan, double share) {
    FitDivision out;
    out.share = share;
    const double finest = sample_spacing(plan, share);
    const std::vector<double> halos = possible_halos(plan.diagonal);
    // halos[first_fine] is that of the level after it.
    while (out.first_fine < kFinestLevel &&
           halos[static_cast<std::size_t>(out.first_fine)] >= kResolved * finest)
        ++out.first_fine;
    out.halo = halos[static_cast<std::size_t>(out.first_fine - 1)];
    return out;
}

std::uint64_t at_level(const std::vector<std::uint64_t>& within, int level) {
    return within.at(static_cast<std::size_t>(level - 1));
}

/// The last level that the sample still resolves something of.
int last_coarse(const SlicePlan& plan, const FitDivision& division) {
    const double finest = sample_spacing(plan, division.share);
    int level = 1;
    while (level < division.first_fine &&
           level_radius(plan.diagonal, level) > kLastResolved * finest)
        ++level;
    return level;
}

}  // namespace

std::vector<double> possible_halos(double diagonal) {
    std::vector<double> halos;
    for (int level = 1; level <= kFinestLevel; ++level)
        halos.push_back(level_radius(diagonal, level - kHaloRungs));
    return halos;
}

FitDivision divide_fit(const SlicePlan& plan, std::uint64_t memory_bytes) {
    if (plan.slices.size() < 2) return {};
    const std::uint64_t held = points_in_memory(memory_bytes);
    const auto n_points = static_cast<double>(std::max<std::uint64_t>(plan.n_points, 1));
    const double largest = std::min(1.0, static_cast<double>(held) / n_points);
    const auto fits = [&](const FitDivision& d) { return points_held(plan, d) <= held; };
    FitDivision best = division_for(plan, largest);
    // Where all points fit, all are the sample.
    for (double share = largest / 2; largest < 1 && share * n_points >= kFewestSampled;
         share /= 2) {
        const FitDivision other = division_for(plan, share);
        if (fits(other) && (!fits(best) || points_read(plan, other) < points_read(plan, best)))
            best = other;
    }
    const std::vector<double> halos = possible_halos(plan.diagonal);
    while (best.first_fine < kFinestLevel && !fits(best) && !plan.slices_given &&
           halos[static_cast<std::size_t>(best.first_fine)] >= kNarrowestHalo * plan.spacing)
        ++best.first_fine;
    best.halo = halos[static_cast<std::size_t>(best.first_fine - 1)];
    best.last_coarse = last_coarse(plan, best);
    return best;
}

std::uint64_t points_held(const SlicePlan& plan, const FitDivision& division) {
    return at_level(plan.most_within, division.first_fine);
}

bool halo_suffices(const SlicePlan& plan, const FitDivision& division) {
    return division.halo >= kResolved * sample_spacing(plan, division.share);
}

std::uint64_t points_read(const SlicePlan& plan, const FitDivision& division) {
    return at_level(plan.all_within, division.first_fine) +
           static_cast<std::uint64_t>(division.share * static_cast<double>(plan.n_points));
}

}  // namespace slim
