#include "slim/cover/void_ends.h"

#include "slim/cover/leaf_reach.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kLeastReach = 0.04; // over rho: nearer the centre nothing ends
constexpr double kOverhang = 0.75;   // spacings that a rim may stand beyond its end, or a cell

Rim rim_of(const VoidEnd& end) {
    const auto [u, v] = rim_direction(end.direction);
    return {u, v, end.reach};
}

/// How many cells of a set lie beyond each of some reaches in a direction.
class Beyond {
public:
    Beyond(const PointRaster& raster, const CellMask& cells, int direction)
        : cell_(raster.cell), n_(static_cast<std::size_t>(kHitTrim / raster.cell) + 3, 0) {
        const auto [u, v] = rim_direction(direction);
        for_cells(cells, [&](std::size_t x, std::size_t y) {
            const double reach = u * raster.middle_of(x) + v * raster.middle_of(y) - 0.5 * cell_;
            least_ = std::min(least_, reach);
            if (reach >= 0)
                ++n_[std::min(static_cast<std::size_t>(reach / cell_), n_.size() - 1)];
        });
        for (std::size_t i = n_.size() - 1; i-- > 0;) n_[i] += n_[i + 1];
    }
    /// Where the nearest begins; may be behind the centre.
    double least() const { return least_; }
    double count(std::size_t step) const { return n_[step]; }
    std::size_t steps() const { return n_.size(); }
    std::size_t step_of(double reach) const {
        return std::min(static_cast<std::size_t>(std::max(0.0, reach) / cell_), n_.size() - 1);
    }

private:
    double cell_, least_ = 1;
    std::vector<std::uint32_t> n_;
};

/// The end that leaves out all voids and the least of the filled; reach 0 if there is none.
VoidEnd end_before_all(const PointRaster& raster, const CellMask& voids, const CellMask& filled) {
    VoidEnd best{0, 0};
    double least = INFINITY;
    for (int k = 0; k < kRimDirections; ++k) {
        const Beyond bare(raster, voids, k);
        if (bare.least() < kLeastReach) continue;
        const Beyond full(raster, filled, k);
        const double lost = full.count(full.step_of(bare.least()));
        if (lost > least || (lost == least && bare.least() <= best.reach)) continue;
        least = lost, best = {k, bare.least()};
    }
    return best;
}

/// The end that leaves out the most of the voids for what it costs.
VoidEnd end_before_most(const PointRaster& raster, const CellMask& voids, const CellMask& filled) {
    VoidEnd best{0, 0};
    double most = 0;
    const double price = static_cast<double>(voids.count()) /
                         (10.0 * static_cast<double>(std::max<std::size_t>(filled.count(), 1)));
    for (int k = 0; k < kRimDirections; ++k) {
        const Beyond bare(raster, voids, k), full(raster, filled, k);
        for (std::size_t i = 1; i < bare.steps(); ++i) {
            const double gain = bare.count(i) - price * full.count(i);
            if (gain > most)
                most = gain, best = {k, static_cast<double>(i) * raster.cell};
        }
    }
    return best;
}

/// The step of a rim that ends there, or a little beyond; 0 where none does.
int step_at(double reach, double overhang) {
    const double step = std::max(1.0, std::ceil(reach / kRimStep - 1e-6));
    return kRimStep * step - reach <= overhang ? static_cast<int>(step) : 0;
}

PackedRim packed(const VoidEnd& end, int step) {
    return pack_rim(end.direction, kRimStep * (step - 0.5));
}

bool is_beyond(const Rim& rim, const Covered& p) {
    return rim.u * static_cast<double>(p.u) + rim.v * static_cast<double>(p.v) > rim.reach;
}

/// Takes out the points that others are to cover: those beyond the ends, and those within a spacing
/// of them where data go on beyond, lest a crack opens between two leaves' last points. Its own
/// point and its centre stay.
void leave_out(const LeafVoids& found, std::span<const Rim> rims, std::uint32_t point,
               CoveringSurfel& leaf) {
    const auto goes_on = [&](const Rim& rim, const Covered& p) {
        const double u = static_cast<double>(p.u) + 1.5 * found.spacing * rim.u,
                     v = static_cast<double>(p.v) + 1.5 * found.spacing * rim.v;
        if (u * u + v * v >= 1) return false;
        return !found.voids.at(found.raster.cell_of(static_cast<float>(u)),
                               found.raster.cell_of(static_cast<float>(v)));
    };
    const auto is_others = [&](const Covered& p) {
        return std::any_of(rims.begin(), rims.end(), [&](const Rim& rim) {
            const double inside =
                rim.reach - rim.u * static_cast<double>(p.u) - rim.v * static_cast<double>(p.v);
            const bool is_own = p.point == point || (p.u == 0 && p.v == 0);
            return inside < 0 || (!is_own && inside < found.spacing && goes_on(rim, p));
        });
    };
    std::size_t n = 0;
    for (const Covered& p : leaf.covered)
        if (!is_others(p)) leaf.covered[n++] = p;
    leaf.covered.resize(n);
}

}  // namespace

CellMask within(const PointRaster& raster, const CellMask& cells, const Rim& rim) {
    if (rim.is_whole()) return cells;
    CellMask out = cells;
    for_cells(cells, [&](std::size_t x, std::size_t y) {
        if (rim.u * raster.middle_of(x) + rim.v * raster.middle_of(y) > rim.reach)
            out.rows[y] &= ~(std::uint64_t{1} << x);
    });
    return out;
}

void find_ends(const CellMask& voids, const CellMask& filled, LeafVoids& out) {
    out.ends[0] = end_before_all(out.raster, voids, filled);
    if (out.ends[0].reach > 0) {
        out.n_ends = 1;
        return;
    }
    out.ends[0] = end_before_most(out.raster, voids, filled);
    if (!(out.ends[0].reach > 0)) return;
    const Rim first = rim_of(out.ends[0]);
    const CellMask rest = within(out.raster, voids, first);
    out.ends[1] = end_before_all(out.raster, rest, within(out.raster, filled, first));
    if (out.ends[1].reach > 0) out.n_ends = 2;
}

bool end_at_voids(const LeafVoids& found, std::uint32_t point, CoveringSurfel& leaf,
                  double& share) {
    PackedRims rims;
    std::array<Rim, 2> ends;
    share = 1;
    for (std::size_t i = 0; i < found.n_ends; ++i) {
        const VoidEnd& end = found.ends[i];
        int step =
            step_at(end.reach, std::max(kOverhang * found.spacing, found.raster.cell));
        if (step == 0 && i == 0) {
            share = end.reach / (kRimStep * std::ceil(end.reach / kRimStep));
            return false;
        }
        if (step == 0) step = static_cast<int>(end.reach / kRimStep);
        if (step == 0) {
            share = kGoldenRatio;
            return false;
        }
        if (step > kRimReaches) {  // no rim stands so far out: the void beyond what is drawn
            share = end.reach / kHitTrim;
            return false;
        }
        (i == 0 ? rims.first : rims.second) = packed(end, step);
        ends[i] = rim_of({end.direction, kRimStep * step});
    }
    const std::span<const Rim> used = std::span(ends).first(found.n_ends);
    const auto keeps_point = [&](const Covered& p) {
        return p.point == point && p.in_core &&
               std::none_of(used.begin(), used.end(),
                            [&](const Rim& rim) { return is_beyond(rim, p); });
    };
    if (std::none_of(leaf.covered.begin(), leaf.covered.end(), keeps_point)) return false;
    if (rims.first == 0) std::swap(rims.first, rims.second);
    leaf.void_rims = rims;
    leave_out(found, used, point, leaf);
    return true;
}

}  // namespace slim
