#include "slim/normals/patch_signs.h"

#include "slim/base/parallel.h"
#include "slim/normals/outside.h"
#include "slim/normals/seam.h"
#include "slim/normals/sign_merge.h"
#include "slim/normals/sign_vote.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kNeighbors = 12;
constexpr std::size_t kGrain = 4096;  // points a task
constexpr std::uint32_t kNone = ~0u;
constexpr double kAgree = 0.7;               // vote that joins two points
constexpr std::uint32_t kFewestOfPatch = 50;
constexpr double kFewestOfSide = 3;  // of a border: neighbours
constexpr double kClear = 0.8;       // |sum of votes| over their sizes
// sizes of votes of two patches that say they agree, if only over an edge, or oppose each other
constexpr double kFewestFor = 8, kFewestAgainst = 20;
constexpr double kBeside = 0.5;      // share of the points that touch both that see a border
constexpr double kBehind = 0.2;      // mean sine of opposed neighbours behind: a thin sheet
constexpr double kFewContrary = 0.25;

/// What the border of two patches says.
struct Border {
    double votes = 0, size = 0, across = 0, n_opposed = 0;
    double n_touching = 0, n_beside = 0;

    Border& operator+=(const Border& o) {
        votes += o.votes, size += o.size, across += o.across, n_opposed += o.n_opposed;
        n_touching += o.n_touching, n_beside += o.n_beside;
        return *this;
    }
    bool is_clear() const {
        if (std::abs(votes) < kClear * size) return false;
        if (votes > 0) return size >= kFewestFor;
        return size >= kFewestAgainst && n_beside > kBeside * n_touching &&
               std::abs(across) < kBehind * n_opposed;
    }
};

using Borders = std::map<std::pair<std::uint32_t, std::uint32_t>, Border>;

/// A cloud's patches.
class Patches {
public:
    Patches(const PointBlock& points, const NearestSearch& search)
        : points_(points), of_(points.size(), kNone), neighbors_(kNeighbors * points.size()) {
        std::vector<std::uint32_t> wanted;
        for (std::uint32_t i = 0; i < points.size(); ++i)
            if (!search.is_repeat(i) && sq_length(points.normal[i]) > 0) wanted.push_back(i);
        n_found_.assign(points.size(), 0);
        search.for_each(wanted, kNeighbors,
                        [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
                            std::copy(neighbors.begin(), neighbors.end(),
                                      neighbors_.begin() + offset(wanted[w]));
                            n_found_[wanted[w]] = static_cast<std::uint8_t>(neighbors.size());
                        });
        join();
        for (std::uint32_t i = 1; i < points.size(); ++i)  // repeats are nobody's neighbours
            if (search.is_repeat(i) && dot(points.normal[i], points.normal[i - 1]) > 0)
                of_[i] = of_[i - 1];
    }

    std::uint32_t n() const { return n_; }
    std::uint32_t of(std::size_t i) const { return of_[i]; }

    Borders borders() const {
        std::vector<Borders> parts((points_.size() + kGrain - 1) / kGrain);
        parallel_blocks(points_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                ask(static_cast<std::uint32_t>(i), parts[begin / kGrain]);
        });
        Borders all;
        for (const Borders& part : parts)
            for (const auto& [pair, border] : part) all[pair] += border;
        return all;
    }

private:
    std::span<const std::uint32_t> around(std::size_t i) const {
        return {neighbors_.data() + i * kNeighbors, n_found_[i]};
    }
    static std::ptrdiff_t offset(std::uint32_t i) {
        return static_cast<std::ptrdiff_t>(i * kNeighbors);
    }
    double vote(std::uint32_t i, std::uint32_t k) const {
        const Vec3d d = points_.position[k] - points_.position[i];
        const double sq = sq_length(d);
        return sq > 0 ? sign_vote(to_double(points_.normal[k]), to_double(points_.normal[i]), d, sq)
                      : 0;
    }

    /// Numbers the patches that are large enough.
    void join() {
        SignedForest forest(points_.size());
        for (std::uint32_t i = 0; i < points_.size(); ++i)
            for (const std::uint32_t k : around(i))
                if (vote(i, k) > kAgree) forest.join(i, k, false);
        std::vector<std::uint32_t> size(points_.size(), 0), number(points_.size(), kNone);
        for (std::uint32_t i = 0; i < points_.size(); ++i) ++size[forest.find(i).index];
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            const std::uint32_t root = forest.find(i).index;
            if (size[root] < kFewestOfPatch) continue;
            if (number[root] == kNone) number[root] = n_++;
            of_[i] = number[root];
        }
    }

    /// What point i says of the border of its own patch and the one that most others are of.
    void ask(std::uint32_t i, Borders& borders) const {
        const std::uint32_t own = of_[i];
        if (own == kNone) return;
        const std::uint32_t other = other_patch(i);
        if (other == kNone) return;
        SeamSides<double> sides;
        double sq_reach = 0;
        Border said;
        for (const std::uint32_t k : around(i)) {
            const Vec3d d = points_.position[k] - points_.position[i];
            const double sq = sq_length(d);
            sq_reach = std::max(sq_reach, sq);
            if (k == i || !(sq > 0)) continue;
            if (of_[k] == own) sides.add(d, true);
            if (of_[k] != other) continue;
            sides.add(d, false);
            const double v = vote(i, k);
            said.votes += v * std::abs(v);
            said.size += v * v;
            if (v >= 0) continue;
            // Seen from the patch of lower number, so that both ways add up.
            const double height = own < other ? dot(to_double(points_.normal[i]), d)
                                              : -dot(to_double(points_.normal[k]), d);
            said.across += height / std::sqrt(sq);
            said.n_opposed += 1;
        }
        if (!sides.have(kFewestOfSide)) return;
        Border& border = borders[std::minmax(own, other)];
        border.n_touching += 1;
        if (!sides.lie_apart(sq_reach)) return;
        said.n_beside = 1;
        border += said;
    }

    /// That most of the neighbours in other patches are of; of two the lower number.
    std::uint32_t other_patch(std::uint32_t i) const {
        std::uint32_t best = kNone;
        std::ptrdiff_t most = 0;
        for (const std::uint32_t k : around(i)) {
            if (of_[k] == of_[i] || of_[k] == kNone) continue;
            const std::ptrdiff_t n =
                std::count_if(around(i).begin(), around(i).end(),
                              [&](std::uint32_t j) { return of_[j] == of_[k]; });
            if (n > most || (n == most && of_[k] < best)) best = of_[k], most = n;
        }
        return best;
    }

    const PointBlock& points_;
    std::vector<std::uint32_t> of_, neighbors_;
    std::vector<std::uint8_t> n_found_;
    std::uint32_t n_ = 0;
};

/// Patches that hang together: which side is the wrong one.
struct Side {
    Vec3d centroid;
    double n = 0, n_turned = 0;       ///< points, and those that oppose the root
    double flux = 0, reach = 0;       ///< as the root has it

    bool is_root_wrong() const {
        const double turned = n_turned / n;
        if (std::min(turned, 1 - turned) > kFewContrary && std::abs(flux) > kClearFlux * reach)
            return flux < 0;
        return turned > 0.5;
    }
};

std::vector<Side> sides_of(const PointBlock& points, const Patches& patches,
                           SignedForest& forest) {
    std::vector<Side> sides(patches.n());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (patches.of(i) == kNone) continue;
        const SignedForest::Root root = forest.find(patches.of(i));
        Side& side = sides[root.index];
        side.centroid += points.position[i];
        side.n += 1;
        side.n_turned += root.flipped;
    }
    for (Side& side : sides) side.centroid = side.centroid / std::max(side.n, 1.0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (patches.of(i) == kNone) continue;
        const SignedForest::Root root = forest.find(patches.of(i));
        Side& side = sides[root.index];
        const Vec3d arm = points.position[i] - side.centroid;
        const double along = dot(arm, to_double(points.normal[i]));
        side.flux += root.flipped ? -along : along;
        side.reach += length(arm);
    }
    return sides;
}

}  // namespace

ContraryPatches contrary_patches(const PointBlock& points, const NearestSearch& search) {
    const Patches patches(points, search);
    std::vector<SignVote> votes;
    bool any_opposed = false;
    for (const auto& [pair, border] : patches.borders()) {
        if (!border.is_clear()) continue;
        votes.push_back({pair.first, pair.second, border.votes});
        any_opposed |= border.votes < 0;
    }
    ContraryPatches found;
    if (!any_opposed) return found;
    SignedForest forest = merge_by_votes(patches.n(), std::move(votes));
    const std::vector<Side> sides = sides_of(points, patches, forest);
    found.is_contrary.assign(points.size(), false);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (patches.of(i) == kNone) continue;
        const SignedForest::Root root = forest.find(patches.of(i));
        const Side& side = sides[root.index];
        if (side.n_turned == 0 || root.flipped == side.is_root_wrong()) continue;
        found.is_contrary[i] = true;
        ++found.n;
    }
    if (found.n == 0) found.is_contrary.clear();
    return found;
}

}  // namespace slim
