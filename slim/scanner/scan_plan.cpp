#include "slim/scanner/scan_plan.h"

#include "slim/base/parallel.h"
#include "slim/scanner/range_grid.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::uint64_t kBandRows = 32;

/// Share of a coarse row that returns, losses at grazing angles counted by their probability.
double row_share(const Shape& shape, const ScanSettings& settings, const Station& station,
                 std::uint64_t row) {
    constexpr double kCell = 1.0 / static_cast<double>(ReturnEstimate::kCoarse);
    double sum = 0;
    for (std::uint64_t col = 0; col < ReturnEstimate::kCoarse; ++col) {
        const double u = station.u_lo + (station.u_hi - station.u_lo) * kCell *
                                            (static_cast<double>(col) + 0.5);
        const double v = station.v_hi - (station.v_hi - station.v_lo) * kCell *
                                            (static_cast<double>(row) + 0.5);
        const Ray ray{station.position, normalized(station.axes.world_from_local({u, v, 1}))};
        if (const auto hit = first_hit(shape, ray, clip_to_box(ray, shape.bounds)))
            sum += 1 - loss_probability(settings.dropout, hit->cos_incidence);
    }
    return sum * kCell;
}

/// Radical inverse in base 2 or 3 (Halton), shifted to start in the middle of the cell.
double halton(std::uint64_t index, std::uint64_t base) {
    double result = 0, digit = 1;
    for (; index > 0; index /= base) {
        digit /= static_cast<double>(base);
        result += digit * static_cast<double>(index % base);
    }
    return result + 0.5 < 1 ? result + 0.5 : result - 0.5;
}

}  // namespace

ReturnEstimate::ReturnEstimate(const Shape& shape, const ScanSettings& settings,
                               const std::vector<Station>& stations)
    : cumulative_(stations.size() * (kCoarse + 1)) {
    std::vector<double> share(stations.size() * kCoarse);
    parallel_blocks(share.size(), 1, [&](std::size_t i, std::size_t) {
        share[i] = row_share(shape, settings, stations[i / kCoarse], i % kCoarse);
    });
    for (std::size_t s = 0; s < stations.size(); ++s) {
        double* sums = cumulative_.data() + s * (kCoarse + 1);
        for (std::size_t r = 0; r < kCoarse; ++r) sums[r + 1] = sums[r] + share[s * kCoarse + r];
        area_ += stations[s].area() * sums[kCoarse] / static_cast<double>(kCoarse);
    }
}

double ReturnEstimate::expected(const Station& station, std::uint64_t begin,
                                std::uint64_t end) const {
    const double* sums = cumulative_.data() + station.id * (kCoarse + 1);
    const double height = station.v_hi - station.v_lo;
    const auto sum_to = [&](std::uint64_t row) {
        const double x = std::min(1.0, static_cast<double>(row) * station.pitch / height) *
                         static_cast<double>(kCoarse);
        const auto k = std::min<std::uint64_t>(kCoarse - 1, static_cast<std::uint64_t>(x));
        return sums[k] + (x - static_cast<double>(k)) * (sums[k + 1] - sums[k]);
    };
    const double cells = station.area() / (station.pitch * station.pitch);
    return (sum_to(end) - sum_to(begin)) * cells / static_cast<double>(kCoarse);
}

ScanPass plan_pass(const ReturnEstimate& estimate, std::vector<Station> stations, double pitch,
                   std::uint64_t pass, std::uint64_t first_key) {
    ScanPass plan;
    for (std::size_t i = 0; i < stations.size(); ++i) {
        Station& s = stations[i];
        s.set_pitch(pitch);
        s.row_shift = halton(pass, 2);
        s.col_shift = halton(pass, 3);
        for (std::uint64_t row = 0; row < s.rows; row += kBandRows) {
            const std::uint64_t end = std::min(s.rows, row + kBandRows);
            plan.bands.push_back(
                {i, row, end, first_key + plan.rays, estimate.expected(s, row, end)});
            plan.expected += plan.bands.back().expected;
        }
        plan.rays += s.rows * s.cols;
    }
    plan.stations = std::move(stations);
    return plan;
}

}  // namespace slim
