#include "pipeline/fit_division.h"

#include "slim/cover/cover_rules.h"
#include "slim/slicing/block_plan.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kFinestLevel = 40;
/// Radii, in spacings of the sample: of the smallest leaf that is kept (8 times the finest ball's 3.3), and
/// of the last level that can still find one where the sample is 2.6 times as dense as usual.
constexpr double kResolved = 26, kLastResolved = 10;

double sample_spacing(const SlicePlan& plan, const FitDivision& division) {
    return plan.spacing / std::sqrt(division.share);
}

}  // namespace

std::vector<double> possible_halos(double diagonal) {
    std::vector<double> halos;
    for (int level = 1; level <= kFinestLevel; ++level)
        halos.push_back(level_radius(diagonal, level - kHaloRungs));
    return halos;
}

FitDivision divide_fit(const SlicePlan& plan, std::uint64_t memory_bytes) {
    FitDivision out;
    if (plan.slices.size() < 2) return out;
    const std::uint64_t held = points_in_memory(memory_bytes);
    out.share = std::min(1.0, static_cast<double>(held) /
                                  static_cast<double>(std::max<std::uint64_t>(plan.n_points, 1)));
    const double finest = sample_spacing(plan, out);
    const std::vector<double> halos = possible_halos(plan.diagonal);
    const auto fits = [&](int level) {
        return plan.most_within.at(static_cast<std::size_t>(level - 1)) <= held;
    };
    const auto halo_of = [&](int level) { return halos[static_cast<std::size_t>(level - 1)]; };
    while (out.first_fine < kFinestLevel &&
           (halo_of(out.first_fine + 1) >= kResolved * finest || !fits(out.first_fine)))
        ++out.first_fine;
    out.halo = halo_of(out.first_fine);
    while (out.last_coarse < out.first_fine &&
           level_radius(plan.diagonal, out.last_coarse) > kLastResolved * finest)
        ++out.last_coarse;
    return out;
}

bool halo_suffices(const SlicePlan& plan, const FitDivision& division) {
    return division.halo >= kResolved * sample_spacing(plan, division);
}

}  // namespace slim
