#include "slim/cover/leaf_rim.h"

#include "slim/cover/leaf_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slim {
namespace {

/// Where edges are real, of leaves of few points: more stand beside the surfaces that others cover
/// as wholes.
constexpr double kMarginOfFew = 0.15;
constexpr std::size_t kFew = 8;
constexpr double kMarginOfWire = 0.04;
// over rho: so far an edge's own points may lie before the last covered one
constexpr double kOnEdge = 0.12;
constexpr double kAlike = 1e-6;   // over rho: reaches that differ by rounding
constexpr double kOfEdge = 0.1;   // over rho: so far covered points may lie beyond an edge
constexpr double kNoRim = 1;      // over rho: where the ball ends
// over rho: so far a leaf may be drawn beyond an edge before it is made smaller
constexpr double kBeyondEdge = 0.02;
constexpr int kLeastShare = 78;   // hundredths of its radius: to where a rim is none, 0.56 / 0.72
constexpr int kTogether = 2;      // directions, 22 degrees: signs of one edge
constexpr int kLeans = 4;  // directions, 45 degrees: a corner's own point leans between its edges

/// How far the leaf may reach in each direction, over rho.
struct Bounds {
    std::array<double, kRimDirections> reach;
    PerDirection lean{};  ///< how well an edge's own points say so

    /// Of those that reach equally far the one that normals lean to the most.
    int nearest() const {
        int best = 0;
        for (int k = 1; k < kRimDirections; ++k) {
            const double less = reach[direction(best)] - reach[direction(k)];
            const float more = lean[direction(k)] - lean[direction(best)];
            if (less > (more > 0 ? -kAlike : more < 0 ? kAlike : 0)) best = k;
        }
        return best;
    }
    void leave_out(int k, int width) {
        for (int d = -width; d <= width; ++d)
            reach[direction(k + d)] = kNoRim, lean[direction(k + d)] = 0;
    }
};

/// Sums of the signs of edges by direction; those that would cut off covered points say nothing.
struct EdgeVotes {
    std::array<int, kRimDirections> n{};
    std::array<double, kRimDirections> reach{};

    EdgeVotes(const std::vector<EdgeSign>& edges, const PerDirection& covered) {
        for (const EdgeSign& e : edges) {
            const double angle = std::atan2(e.v, e.u) / (2 * std::numbers::pi) * kRimDirections;
            const std::size_t k = direction(static_cast<int>(std::lround(angle)));
            if (static_cast<double>(covered[k]) > static_cast<double>(e.reach) + kOfEdge) continue;
            ++n[k], reach[k] += static_cast<double>(e.reach);
        }
    }
    /// Mean reach of the signs about a direction that has the most of them; kNoRim elsewhere.
    double mean(int k) const {
        int count = 0;
        double sum = 0;
        for (int d = -kTogether; d <= kTogether; ++d) {
            const std::size_t i = direction(k + d);
            if (n[i] > n[direction(k)]) return kNoRim;
            count += n[i], sum += reach[i];
        }
        return count > 0 ? sum / count : kNoRim;
    }
};

/// How well the normals of an edge's own points that are the last covered ones in a direction lean
/// there: the sum of the cosines; 0 where the leaf does not end at such points.
PerDirection ends_of(const std::vector<EdgePoint>& edge_points, const PerDirection& covered) {
    PerDirection ends{};
    for (const EdgePoint& p : edge_points) {
        const double angle = std::atan2(p.v, p.u) / (2 * std::numbers::pi) * kRimDirections;
        const int nearest = static_cast<int>(std::lround(angle));
        for (int k = nearest - kLeans; k <= nearest + kLeans; ++k) {
            const std::size_t i = direction(k);
            const auto [u, v] = rim_direction(static_cast<int>(i));
            const double reach = u * static_cast<double>(p.x) + v * static_cast<double>(p.y);
            const double lean = u * static_cast<double>(p.u) + v * static_cast<double>(p.v);
            if (reach >= static_cast<double>(covered[i]) - kOnEdge)
                ends[i] += static_cast<float>(lean);
        }
    }
    return ends;
}

Bounds bounds_of(const CoveringSurfel& leaf, const PerDirection& covered) {
    const auto n = static_cast<double>(leaf.covered.size());
    const EdgeVotes votes(leaf.edges, covered);
    Bounds out;
    out.lean = ends_of(leaf.edge_points, covered);
    for (int k = 0; k < kRimDirections; ++k) {
        const double last = static_cast<double>(covered[direction(k)]);
        double margin = end_beyond(last, n).margin;
        if (leaf.on_wire) margin = std::min(margin, kMarginOfWire);
        if (leaf.edges_are_real && leaf.covered.size() < kFew)
            margin = std::min(margin, kMarginOfFew);
        out.reach[direction(k)] = std::min(last + margin, std::max(last, votes.mean(k)));
        if (out.lean[direction(k)] > 0) out.reach[direction(k)] = last;
    }
    return out;
}

/// The rim before the most of those places, which it takes out; 0 where none has any beyond it.
/// Covered points stay inside.
PackedRim rim_before(std::vector<AirPlace>& air, const PerDirection& covered) {
    const auto reach = [](const AirPlace& p, int k) {
        const auto [u, v] = rim_direction(k);
        return u * static_cast<double>(p.u) + v * static_cast<double>(p.v);
    };
    std::ptrdiff_t most = 0;
    int best = 0, best_step = 0;
    for (int k = 0; k < kRimDirections; ++k)
        for (int step = kRimReaches;
             step > 0 && kRimStep * step >= static_cast<double>(covered[direction(k)]); --step) {
            const auto n = std::count_if(air.begin(), air.end(), [&](const AirPlace& p) {
                return reach(p, k) >= kRimStep * step;
            });
            if (n > most) most = n, best = k, best_step = step;
        }
    if (most == 0) return 0;
    std::erase_if(air, [&](const AirPlace& p) { return reach(p, best) >= kRimStep * best_step; });
    return pack_rim(best, kRimStep * (best_step - 0.5));
}

PackedRim rim_at(const Bounds& bounds) {
    const int k = bounds.nearest();
    return pack_rim(k, bounds.reach[direction(k)]);
}

/// By how much a leaf that ends at that reach is drawn beyond it, over rho, in a ball `share` times
/// as large.
double drawn_beyond(double reach, double share) {
    const double step = std::max(1.0, std::ceil(reach / share / kRimStep - kAlike));
    const double end = step <= kRimReaches ? kRimStep * step : kHitTrim;
    return share * end - reach;
}

/// The edges that the ball's points show, nearest first, as rims_of takes them.
std::array<double, 2> nearest_edges(const CoveringSurfel& leaf, const PerDirection& covered) {
    Bounds bounds = bounds_of(leaf, covered);
    const EdgeVotes votes(leaf.edges, covered);
    for (int k = 0; k < kRimDirections; ++k)
        if (!(votes.mean(k) < kNoRim) && !(bounds.lean[direction(k)] > 0))
            bounds.reach[direction(k)] = kNoRim;
    std::array<double, 2> out{};
    for (double& reach : out) {
        const int k = bounds.nearest();
        reach = bounds.reach[direction(k)];
        bounds.leave_out(k, kEndsApart);
    }
    return out;
}

}  // namespace

double share_at_edges(const CoveringSurfel& leaf) {
    if (leaf.fitted.surfel.sharp || leaf.covered.empty()) return 1;
    const auto covered = reaches_of(leaf, kHitTrim);
    if (!covered) return 1;
    const auto edges = nearest_edges(leaf, *covered);
    const auto beyond = [&](double share) {
        double most = 0;
        for (const double reach : edges)
            if (reach < kHitTrim) most = std::max(most, drawn_beyond(reach, share));
        return most;
    };
    for (int hundredths = 100; hundredths >= kLeastShare; --hundredths)
        if (beyond(hundredths / 100.0) <= kBeyondEdge) return hundredths / 100.0;
    return 1;
}

PackedRims rims_of(const CoveringSurfel& leaf) {
    if (leaf.fitted.surfel.sharp || leaf.covered.empty()) return {};
    const auto reaches = reaches_of(leaf);
    if (!reaches || leaf.void_rims.second != 0) return leaf.void_rims;
    std::vector<AirPlace> air = leaf.air;
    PackedRims rims = leaf.void_rims;
    if (rims.first == 0) rims.first = rim_before(air, *reaches);
    if (rims.first != 0) rims.second = rim_before(air, *reaches);
    if (rims.second != 0) return rims;
    Bounds bounds = bounds_of(leaf, *reaches);
    if (rims.first == 0) rims.first = rim_at(bounds);
    if (rims.first == 0) return rims;
    bounds.leave_out(rims.first >> 3, kEndsApart);
    rims.second = rim_at(bounds);
    return rims;
}

}  // namespace slim
