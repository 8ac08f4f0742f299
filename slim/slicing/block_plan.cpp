#include "slim/slicing/block_plan.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace slim {
namespace {

constexpr double kFarOff = 0.1;  // of a block's points
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Bbox kEverywhere{{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};

std::uint64_t count(std::span<const Cell> cells) {
    return std::accumulate(cells.begin(), cells.end(), std::uint64_t{0},
                           [](std::uint64_t n, const Cell& c) { return n + c.n_points; });
}

/// Cuts cells again and again.
class Cutter {
public:
    Cutter(BlockPlan& plan, double width) : plan_(plan), width_(width) {}

    /// Returns what stands for the part in its parent's split.
    std::int32_t cut(std::span<Cell> cells, std::uint64_t wanted, const Bbox& region) {
        std::size_t axis = 0;
        std::int64_t at = 0;
        if (wanted < 2 || !find_cut(cells, wanted, axis, at)) {
            plan_.n_points.push_back(count(cells));
            plan_.regions.push_back(region);
            return -static_cast<std::int32_t>(plan_.n_points.size());
        }
        const auto middle = std::partition(cells.begin(), cells.end(),
                                           [=](const Cell& c) { return c.at[axis] < at; });
        const auto n_below = static_cast<std::size_t>(middle - cells.begin());
        const auto split = plan_.splits.size();
        plan_.splits.push_back({axis, static_cast<double>(at) * width_, 0, 0});
        Bbox below = region, above = region;
        below.hi[axis] = above.lo[axis] = plan_.splits[split].cut;
        const std::int32_t first = cut(cells.first(n_below), wanted / 2, below);
        const std::int32_t second = cut(cells.subspan(n_below), wanted - wanted / 2, above);
        plan_.splits[split].below = first;
        plan_.splits[split].above = second;
        return static_cast<std::int32_t>(split);
    }

private:
    /// Between two layers of cells, as near as can be to the share of half of the blocks: across
    /// the longest side, or if its layers are too full, as of a flat base, across another.
    static bool find_cut(std::span<const Cell> cells, std::uint64_t wanted, std::size_t& axis,
                         std::int64_t& at) {
        std::array<std::int64_t, 3> sides;
        for (std::size_t a = 0; a < 3; ++a) sides[a] = side(cells, a);
        std::array<std::size_t, 3> axes{0, 1, 2};
        std::stable_sort(axes.begin(), axes.end(),
                         [&](std::size_t a, std::size_t b) { return sides[a] > sides[b]; });
        const double block = static_cast<double>(count(cells)) / static_cast<double>(wanted);
        double nearest = kInfinity;
        for (const std::size_t a : axes) {
            const auto [layer, off] =
                nearest_layer(cells, a, block * static_cast<double>(wanted / 2));
            if (off < nearest) nearest = off, axis = a, at = layer;
            if (nearest <= kFarOff * block) break;
        }
        return nearest < kInfinity;
    }
    static std::int64_t side(std::span<const Cell> cells, std::size_t axis) {
        const auto [lo, hi] = std::minmax_element(
            cells.begin(), cells.end(),
            [axis](const Cell& x, const Cell& y) { return x.at[axis] < y.at[axis]; });
        return hi->at[axis] - lo->at[axis];
    }
    /// The layer below which most nearly so many points lie, and how far off that is; infinitely if
    /// there is one only.
    static std::pair<std::int64_t, double> nearest_layer(std::span<const Cell> cells,
                                                         std::size_t axis, double share) {
        std::map<std::int64_t, std::uint64_t> layers;
        for (const Cell& c : cells) layers[c.at[axis]] += c.n_points;
        std::pair<std::int64_t, double> nearest{0, kInfinity};
        double below = 0;
        for (const auto& [layer, n] : layers) {
            const double off = std::abs(below - share);
            if (below > 0 && off < nearest.second) nearest = {layer, off};
            below += static_cast<double>(n);
        }
        return nearest;
    }

    BlockPlan& plan_;
    double width_;
};

/// How far a cell lies from a region along the axis where that is farthest.
double distance(const Bbox& region, const Cell& cell, double width) {
    double farthest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double lo = static_cast<double>(cell.at[axis]) * width;
        farthest = std::max({farthest, region.lo[axis] - (lo + width), lo - region.hi[axis]});
    }
    return farthest;
}

}  // namespace

std::uint64_t points_in_memory(std::uint64_t memory_bytes) {
    const std::uint64_t left = memory_bytes > kProgramBytes ? memory_bytes - kProgramBytes : 0;
    return std::max<std::uint64_t>(1, left / kBytesPerPoint);
}

bool is_in(const Bbox& region, const Vec3d& p) {
    bool in = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
        in &= p[axis] >= region.lo[axis] && p[axis] < region.hi[axis];
    return in;
}

bool is_near(const Bbox& region, const Vec3d& p, double distance) {
    bool near = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
        near &= p[axis] >= region.lo[axis] - distance && p[axis] <= region.hi[axis] + distance;
    return near;
}

bool comes_near(const Bbox& region, const Bbox& box, double distance) {
    bool near = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
        near &= box.hi[axis] >= region.lo[axis] - distance &&
                box.lo[axis] <= region.hi[axis] + distance;
    return near;
}

bool is_near(const Bbox& region, const Bbox& box, double distance) {
    return is_near(region, box.lo, distance) && is_near(region, box.hi, distance);
}

std::size_t BlockPlan::block_of(const Vec3d& p) const {
    if (splits.empty()) return 0;
    std::int32_t at = 0;
    while (at >= 0) {
        const Split& s = splits[static_cast<std::size_t>(at)];
        at = p[s.axis] < s.cut ? s.below : s.above;
    }
    return static_cast<std::size_t>(-1 - at);
}

BlockPlan plan_blocks(std::vector<Cell> cells, double width, std::uint64_t wanted) {
    SLIM_CHECK(wanted, >=, 1u);
    SLIM_CHECK(cells.size(), >=, 1u);
    BlockPlan plan;
    Cutter(plan, width).cut(cells, wanted, kEverywhere);
    return plan;
}

HaloCounts count_within(const BlockPlan& plan, std::span<const Cell> cells, double width,
                        std::span<const double> halos) {
    std::vector<std::vector<std::uint64_t>> within(plan.n_blocks());
    parallel_blocks(plan.n_blocks(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            within[b].assign(halos.size(), 0);
            for (const Cell& c : cells) {
                const double d = distance(plan.regions[b], c, width);
                for (std::size_t h = 0; h < halos.size() && d <= halos[h]; ++h)
                    within[b][h] += c.n_points;
            }
        }
    });
    HaloCounts out{std::vector<std::uint64_t>(halos.size()),
                   std::vector<std::uint64_t>(halos.size())};
    for (const auto& of_block : within)
        for (std::size_t h = 0; h < halos.size(); ++h) {
            out.most[h] = std::max(out.most[h], of_block[h]);
            out.all[h] += of_block[h];
        }
    return out;
}

}  // namespace slim
