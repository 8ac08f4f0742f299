#include "slim/neighbors/nearest.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

namespace slim {
namespace {

using DoubleV = stdx::native_simd<double>;
constexpr std::size_t kDoubles = DoubleV::size();
constexpr std::size_t kWord = 64;       // candidates whose hits are bits of one word
constexpr std::size_t kGrain = 1024;    // wanted points a task
constexpr double kFar = 1e200;          // of padding: its square is infinite
constexpr double kCompact = 4;          // queries share a walk if their box is
                                        // at most so many radii wide
constexpr double kBeyond = 1 + 1e-9;    // wider by more than rounding
constexpr double kNextRadius = 1.25;    // of the k-th distance of the query before: a guess
constexpr double kNextReach = 1.4;      // of the mean k-th distance of the bucket before: a guess
constexpr double kMostGrowth = 2;       // of the reach from one query to the next
constexpr std::size_t kTasks = 32;      // where few points are wanted
constexpr std::size_t kFewest = 8;      // of them a task
constexpr int kMostSteps = 16;          // of the search for a radius that
                                        // holds k; more only with ties

DoubleV lanes_at(const std::vector<double>& a, std::size_t i) {
    return DoubleV(&a[i], stdx::element_aligned);
}

/// Distinct places near some queries, as flat arrays padded to whole words.
struct Candidates {
    std::vector<double> x, y, z;
    std::vector<std::uint32_t> index;
    std::size_t n = 0;

    void clear() { n = 0; }
    void add(const NearestSearch& search, std::size_t begin, std::size_t end) {
        if (n + BoxTree::kBucket + kWord > index.size()) grow();
        const bool any_repeats = search.has_repeats(begin / BoxTree::kBucket);
        const Vec3d* const positions = search.positions().data();
        double *px = &x[n], *py = &y[n], *pz = &z[n];
        std::uint32_t* const to = &index[n];
        std::size_t added = 0;
        for (std::size_t i = begin; i < end; ++i) {
            px[added] = positions[i].x, py[added] = positions[i].y, pz[added] = positions[i].z;
            to[added] = static_cast<std::uint32_t>(i);
            added += any_repeats && search.is_repeat(i) ? 0 : 1;
        }
        n += added;
    }
    /// Call when all are added.
    void pad() {
        if (index.empty()) grow();
        for (std::size_t i = n; i % kWord != 0; ++i) x[i] = y[i] = z[i] = kFar;
    }

private:
    void grow() {
        const std::size_t size = 2 * index.size() + 512;
        for (auto* a : {&x, &y, &z}) a->resize(size);
        index.resize(size);
    }
};

/// The candidates within some radius of a query, distances and indices in arrays padded to whole
/// lanes.
struct Hits {
    std::vector<double> sq;
    std::vector<std::uint32_t> index;
    std::size_t n = 0;

    /// All candidates with squared distance <= limit.
    void collect(const Candidates& c, const Vec3d& p, double limit) {
        if (index.size() < c.n + kDoubles)
            sq.resize(2 * c.n + kWord), index.resize(2 * c.n + kWord);
        n = 0;
        alignas(64) double distances[kWord];
        for (std::size_t i = 0; i < c.n; i += kWord) {
            std::uint64_t bits = 0;
            for (std::size_t k = 0; k < kWord; k += kDoubles) {
                const DoubleV dx = lanes_at(c.x, i + k) - p.x, dy = lanes_at(c.y, i + k) - p.y,
                              dz = lanes_at(c.z, i + k) - p.z;
                const DoubleV d = dx * dx + dy * dy + dz * dz;
                d.copy_to(distances + k, stdx::element_aligned);
                bits |= lane_bits(d <= limit) << k;
            }
            for (; bits != 0; bits &= bits - 1, ++n) {
                const auto k = static_cast<std::size_t>(std::countr_zero(bits));
                sq[n] = distances[k], index[n] = c.index[i + k];
            }
        }
        pad();
    }

    /// Leaves the k nearest.
    void keep_nearest(std::size_t k) {
        if (n <= k) return;
        // In the plane the number of points grows with the square of the radius: a secant finds the
        // k-th fast.
        double lo = 0, hi = farthest();
        std::size_t n_lo = 0, n_hi = n;
        for (int step = 0; step < kMostSteps; ++step) {
            const double share =
                (static_cast<double>(k - n_lo) + 0.5) / static_cast<double>(n_hi - n_lo);
            const double middle = lo + (hi - lo) * std::min(share, 0.9);
            const std::size_t inside = count(middle);
            if (inside == k) return keep_within(middle);
            (inside < k ? lo : hi) = middle;
            (inside < k ? n_lo : n_hi) = inside;
        }
        keep_nearest_of_ties(k);
    }

    double farthest() const {
        DoubleV most = 0;
        for (std::size_t i = 0; i < n; i += kDoubles) {
            const DoubleV d = lanes_at(sq, i);
            most = select(d < kFar, stdx::max(most, d), most);
        }
        return stdx::hmax(most);
    }

private:
    void pad() {
        for (std::size_t i = n; i < n + kDoubles; ++i) sq[i] = kFar;
    }

    std::size_t count(double limit) const {
        int inside = 0;
        for (std::size_t i = 0; i < n; i += kDoubles)
            inside += stdx::popcount(lanes_at(sq, i) <= limit);
        return static_cast<std::size_t>(inside);
    }

    void keep_within(double limit) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const double d = sq[i];
            sq[kept] = d, index[kept] = index[i];
            kept += d <= limit ? 1 : 0;
        }
        n = kept;
        pad();
    }

    /// By distance, then by index.
    void keep_nearest_of_ties(std::size_t k) {
        std::vector<std::pair<double, std::uint32_t>> all(n);
        for (std::size_t i = 0; i < n; ++i) all[i] = {sq[i], index[i]};
        std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(k), all.end());
        for (std::size_t i = 0; i < k; ++i) sq[i] = all[i].first, index[i] = all[i].second;
        n = k;
        pad();
    }
};

/// What one thread works with.
class Searcher {
public:
    Searcher(const NearestSearch& search, std::size_t k, const NearestSearch::Visit& visit)
        : search_(search), visit_(visit), k_(k) {}

    /// wanted: points of one bucket, which are the w-th of all wanted and those after it. A bucket
    /// that straddles a jump of the curve is dealt with in parts.
    void bucket(std::span<const std::uint32_t> wanted, std::size_t w) {
        if (!(reach_ > 0)) reach_ = std::sqrt(bound_from_near_buckets(wanted[0]));
        Bbox box;
        for (const std::uint32_t i : wanted) box.extend(search_.positions()[i]);
        if (wanted.size() == 1) return single(wanted[0], w);
        if (!(box.diagonal() <= kCompact * reach_)) {
            const std::size_t half = wanted.size() / 2;
            bucket(wanted.first(half), w);
            return bucket(wanted.subspan(half), w + half);
        }
        // Every point no farther than reach is among the candidates:
        // boxes just as far are left out.
        const double reach = reach_;
        gather(box, reach * kBeyond);
        double guess = reach, sum = 0;
        left_.clear();
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const Vec3d& p = search_.positions()[wanted[i]];
            if (!is_found(p, std::min(guess, reach)) && !is_found(p, reach)) {
                left_.push_back(static_cast<std::uint32_t>(i));
                continue;
            }
            const double farthest = report(w + i);
            guess = kNextRadius * farthest;
            sum += farthest;
        }
        for (const std::uint32_t i : left_) sum += alone(wanted[i], w + i);
        reach_ = kNextReach * sum / static_cast<double>(wanted.size());
    }

private:
    /// A bucket's only query: most find enough no farther than the one before did. One that is far
    /// from all others says little of the next.
    void single(std::uint32_t i, std::size_t w) {
        const Vec3d& p = search_.positions()[i];
        gather({p, p}, reach_ * kBeyond);
        const double farthest = is_found(p, reach_) ? report(w) : alone(i, w);
        reach_ = kNextReach * std::min(farthest, kMostGrowth * reach_);
    }

    /// A query that shares with nobody. Returns the distance of its farthest neighbour.
    double alone(std::uint32_t i, std::size_t w) {
        const double sq_bound = bound_from_near_buckets(i);
        const Vec3d& p = search_.positions()[i];
        // The point that set the bound must be in.
        gather({p, p}, std::sqrt(sq_bound) * kBeyond + 1e-150);
        hits_.collect(candidates_, p, sq_bound);
        hits_.keep_nearest(k_);
        return report(w);
    }

    /// A squared radius about point i that holds at least k distinct places, or all there are.
    double bound_from_near_buckets(std::size_t i) {
        const std::size_t own = i / BoxTree::kBucket;
        const std::size_t n_buckets = search_.boxes().n_buckets();
        for (std::size_t width = (k_ + BoxTree::kBucket - 1) / BoxTree::kBucket;; width *= 2) {
            const std::size_t first = own - std::min(own, width);
            const std::size_t last = std::min(n_buckets, own + width + 1);
            candidates_.clear();
            for (std::size_t b = first; b < last; ++b)
                candidates_.add(search_, b * BoxTree::kBucket,
                                std::min(search_.size(), (b + 1) * BoxTree::kBucket));
            if (candidates_.n >= k_ || (first == 0 && last == n_buckets)) break;
        }
        candidates_.pad();
        hits_.collect(candidates_, search_.positions()[i], kFar);
        hits_.keep_nearest(k_);
        return hits_.farthest();
    }

    void gather(const Bbox& box, double radius) {
        candidates_.clear();
        search_.boxes().for_buckets_near(box, radius, [&](std::size_t begin, std::size_t end) {
            candidates_.add(search_, begin, end);
        });
        candidates_.pad();
    }

    /// Whether the radius holds k candidates; then the nearest k are the hits.
    bool is_found(const Vec3d& p, double radius) {
        hits_.collect(candidates_, p, radius * radius);
        if (hits_.n < k_) return false;
        hits_.keep_nearest(k_);
        return true;
    }

    /// Hands the hits over; returns the distance of the farthest.
    double report(std::size_t w) {
        visit_(w, {hits_.index.data(), hits_.n});
        return std::sqrt(hits_.farthest());
    }

    const NearestSearch& search_;
    const NearestSearch::Visit& visit_;
    std::size_t k_;
    double reach_ = 0;  // how far the next bucket looks
    Candidates candidates_;
    Hits hits_;
    std::vector<std::uint32_t> left_;
};

}  // namespace

NearestSearch::NearestSearch(std::span<const Vec3d> positions)
    : positions_(positions),
      boxes_(positions.size(), [&](std::size_t i) { return positions[i]; }),
      has_repeats_(boxes_.n_buckets()) {
    parallel_blocks(has_repeats_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b)
            for (std::size_t i = b * BoxTree::kBucket;
                 i < std::min((b + 1) * BoxTree::kBucket, positions.size()); ++i)
                if (is_repeat(i)) has_repeats_[b] = 1;
    });
}

void NearestSearch::for_each(std::span<const std::uint32_t> wanted, std::size_t k,
                             const Visit& visit) const {
    SLIM_CHECK(k, >=, 1u);
    const std::size_t grain = std::clamp(wanted.size() / kTasks, kFewest, kGrain);
    parallel_blocks(wanted.size(), grain, [&](std::size_t begin, std::size_t end) {
        Searcher searcher(*this, k, visit);
        for (std::size_t first = begin; first < end;) {
            const std::size_t bucket = wanted[first] / BoxTree::kBucket;
            std::size_t last = first + 1;
            while (last < end && wanted[last] / BoxTree::kBucket == bucket) ++last;
            searcher.bucket(wanted.subspan(first, last - first), first);
            first = last;
        }
    });
}

}  // namespace slim
