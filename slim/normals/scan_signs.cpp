#include "slim/normals/scan_signs.h"

#include "slim/normals/sign_merge.h"
#include "slim/normals/sign_vote.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kNeighbors = 16;
constexpr double kClear = 0.8;       // |sum of votes| over their sizes
constexpr double kFewestVotes = 20;  // sizes of votes of two scans that say anything
// mean sine from where on opposed neighbours lie behind: a thin sheet, no curved surface
constexpr double kBehind = 0.1;

/// What neighbours of two scans say.
struct PairOfScans {
    double votes = 0, size = 0, across = 0, n_opposed = 0;

    bool is_clear() const {
        if (size < kFewestVotes || std::abs(votes) < kClear * size) return false;
        return votes > 0 || std::abs(across) < kBehind * n_opposed;
    }
};

using Pairs = std::map<std::pair<std::uint32_t, std::uint32_t>, PairOfScans>;

Pairs pairs_of_scans(const PointBlock& points, const NearestSearch& search,
                     std::vector<std::uint32_t> wanted) {
    std::sort(wanted.begin(), wanted.end());
    std::erase_if(wanted, [&](std::uint32_t i) { return search.is_repeat(i); });
    std::vector<std::vector<std::uint32_t>> around(wanted.size());
    search.for_each(wanted, kNeighbors,
                    [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
                        for (const std::uint32_t k : neighbors)
                            if (points.scan[k] != points.scan[wanted[w]]) around[w].push_back(k);
                    });
    Pairs pairs;
    for (std::size_t w = 0; w < wanted.size(); ++w)
        for (const std::uint32_t k : around[w]) {
            const std::uint32_t i = wanted[w];
            const Vec3d d = points.position[k] - points.position[i],
                        n = to_double(points.normal[i]), m = to_double(points.normal[k]);
            const double sq = sq_length(d);
            if (!(sq > 0)) continue;
            const double vote = sign_vote(m, n, d, sq);
            PairOfScans& pair = pairs[std::minmax<std::uint32_t>(points.scan[i], points.scan[k])];
            pair.votes += vote * std::abs(vote);
            pair.size += vote * vote;
            if (vote >= 0) continue;
            // Seen from the scan of lower number, so that both ways add up.
            const double height = points.scan[i] < points.scan[k] ? dot(n, d) : -dot(m, d);
            pair.across += height / std::sqrt(sq);
            pair.n_opposed += 1;
        }
    return pairs;
}

}  // namespace

std::vector<bool> contrary_scans(const PointBlock& points, const NearestSearch& search,
                                 std::span<const std::uint32_t> samples,
                                 std::span<const std::int64_t> facing) {
    if (points.scan.empty()) return {};
    const std::size_t n = 1 + *std::max_element(points.scan.begin(), points.scan.end());
    if (n < 2) return {};
    std::vector<SignVote> votes;
    bool any_opposed = false;
    for (const auto& [scans, pair] :
         pairs_of_scans(points, search, {samples.begin(), samples.end()})) {
        if (!pair.is_clear()) continue;
        votes.push_back({scans.first, scans.second, pair.votes});
        any_opposed |= pair.votes < 0;
    }
    std::vector<bool> contrary(n, false);
    if (!any_opposed) return contrary;
    SignedForest forest = merge_by_votes(static_cast<std::uint32_t>(n), std::move(votes));
    // By root: points as it has it, less those against it; and what sensors say of them.
    std::vector<std::int64_t> balance(n, 0), by_sensors(n, 0);
    for (const std::uint16_t scan : points.scan) {
        const SignedForest::Root root = forest.find(scan);
        balance[root.index] += root.flipped ? -1 : 1;
    }
    for (std::uint32_t scan = 0; scan < std::min(n, facing.size()); ++scan) {
        const SignedForest::Root root = forest.find(scan);
        by_sensors[root.index] += root.flipped ? -facing[scan] : facing[scan];
    }
    for (std::uint32_t scan = 0; scan < n; ++scan) {
        const SignedForest::Root root = forest.find(scan);
        const std::int64_t said = by_sensors[root.index];
        contrary[scan] = root.flipped == ((said != 0 ? said : balance[root.index]) >= 0);
    }
    return contrary;
}

}  // namespace slim
