#include "slim/normals/repair.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/normals/audit_buckets.h"
#include "slim/normals/bucket_audit.h"
#include "slim/normals/seam.h"
#include "slim/normals/sign_vote.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kMajority = 0.5;   // |mean normal| of neighbours that agree among themselves
constexpr double kContrary = -0.3;  // cosine to the majority below which a normal is wrong
constexpr double kClear = 0.7;      // |mean normal| that leaves no doubt
// square of the share of the radius within which neighbours count alike
constexpr float kNear = 0.03f;
constexpr double kDoubt = -0.1;      // votes for a normal above which a majority does not turn it
// Of a seam: opposed pairs of a bucket that is looked at; neighbours on either side.
constexpr double kFewOpposed = 0.05;
constexpr float kFewestOfSide = 4;
constexpr std::size_t kSampledBuckets = 16;  // of one in so many all pairs are compared

constexpr std::size_t kBucket = kAuditBucket;
constexpr std::size_t kShared = kBucket * BoxTree::kFanout;  // points that share a walk of the tree
constexpr std::size_t kGrain = 4096;                         // points a task
static_assert(kGrain % kShared == 0);

/// A bucket that straddles a jump of the curve is as large as the jump: its radius would gather
/// thousands of points. Twice the median serves all but the sparsest 1 %.
double usual_diagonal(const BoxTree& tree) {
    std::vector<double> diagonals(tree.n_buckets());
    for (std::size_t b = 0; b < diagonals.size(); ++b) diagonals[b] = tree.bucket(b).diagonal();
    if (diagonals.empty()) return 0;
    const auto middle = diagonals.begin() + static_cast<std::ptrdiff_t>(diagonals.size() / 2);
    std::nth_element(diagonals.begin(), middle, diagonals.end());
    return *middle;
}

/// A normal that its neighbours overrule.
struct Mended {
    std::size_t point;
    Vec3f normal;
};

/// What one thread works with, and what it found.
class Auditor {
public:
    Auditor(const PointBlock& points, const Neighborhoods& all, double most_radius,
            const std::vector<bool>& counted, const std::vector<bool>& judged)
        : points_(points),
          all_(all),
          most_radius_(most_radius),
          counted_(counted),
          judged_(judged) {}

    /// Points [begin, end), whole buckets but for the last. Those that lie far from each other on
    /// either side of a jump of the curve are taken in parts.
    void audit(std::size_t begin, std::size_t end) {
        const std::size_t n_buckets = (end - begin + kBucket - 1) / kBucket;
        Bbox box;
        for (std::size_t b = 0; b < n_buckets; ++b)
            box.extend(all_.tree.bucket(begin / kBucket + b));
        if (n_buckets > 1 && box.diagonal() > kCompact * most_radius_) {
            const std::size_t middle = begin + n_buckets / 2 * kBucket;
            audit(begin, middle);
            return audit(middle, end);
        }
        bool is_gathered = false;
        for (std::size_t first = begin; first < end; first += kBucket) {
            if (is_plain(first / kBucket) || !is_any_judged(first, std::min(first + kBucket, end)))
                continue;
            if (!std::exchange(is_gathered, true)) around_.gather(all_, box, most_radius_);
            audit_part(first, std::min(first + kBucket, end));
        }
    }

    NormalAudit counts;
    std::vector<Mended> mended;

private:
    static constexpr double kCompact = 8;
    // points of one that straddles a jump, for which sixteen lanes are too many
    static constexpr std::size_t kFewOfBucket = 4;

    /// Whether a bucket needs no closer look: compact, of one mind, and none of those whose pairs
    /// are compared.
    bool is_plain(std::size_t bucket) const {
        return bucket % kSampledBuckets != 0 && (bucket + 1) * kBucket <= points_.size() &&
               all_.tree.bucket(bucket).diagonal() <= 2 * most_radius_ &&
               is_of_one_mind(all_.buckets[bucket]);
    }
    bool is_any_judged(std::size_t begin, std::size_t end) const {
        if (judged_.empty()) return true;
        for (std::size_t i = begin; i < end; ++i)
            if (judged_[i]) return true;
        return false;
    }
    Bbox box_of(std::size_t begin, std::size_t end) const {
        Bbox box;
        for (std::size_t i = begin; i < end; ++i) box.extend(points_.position[i]);
        return box;
    }

    /// Points of one bucket; in parts, too.
    void audit_part(std::size_t begin, std::size_t end) {
        const std::size_t bucket = begin / kBucket;
        const bool is_whole = begin % kBucket == 0 &&
                              end == std::min(begin + kBucket, points_.size());
        const Bbox box = is_whole ? all_.tree.bucket(bucket) : box_of(begin, end);
        if (end - begin > 1 && box.diagonal() > 2 * most_radius_) {
            const std::size_t middle = (begin + end) / 2;
            audit_part(begin, middle);
            return audit_part(middle, end);
        }
        const double radius = std::min(0.5 * all_.tree.bucket(bucket).diagonal(), most_radius_);
        LocalBucket of_part;
        if (!is_whole) of_part.set(points_, begin, end, box.lo);
        const LocalBucket& own = is_whole ? all_.buckets[bucket] : of_part;
        const auto sq_radius = static_cast<float>(radius) * static_cast<float>(radius);
        candidates_.clear();
        around_.for_buckets_near(box, radius, [&](std::size_t b) {
            candidates_.add(all_.buckets[b], to_float(all_.tree.bucket(b).lo - box.lo),
                            to_float(box.extent()), sq_radius);
        });
        if (end - begin <= kFewOfBucket && bucket % kSampledBuckets != 0 &&
            do_all_agree(own, end - begin, sq_radius))
            return;
        Sixteen found(own);
        found.sum_up(candidates_, sq_radius);
        if (bucket % kSampledBuckets == 0) compare_signs(found, own, end - begin, sq_radius);
        const std::uint64_t agreeing = found.agreeing();
        for (std::size_t k = 0; k < end - begin; ++k)
            if ((agreeing >> k & 1) == 0)
                judge(begin + k, found.majority(k),
                      [&] { return votes_for(own, k, sq_radius) > kDoubt; });
    }

    bool do_all_agree(const LocalBucket& own, std::size_t n, float sq_radius) {
        candidates_.pad();
        for (std::size_t k = 0; k < n; ++k)
            if (!agrees(own, k, candidates_, sq_radius)) return false;
        return true;
    }

    // Out of line, as it is called for one bucket in sixteen.
    [[gnu::noinline]] void compare_signs(const Sixteen& found, const LocalBucket& own,
                                         std::size_t n, float sq_radius) {
        const double opposed = counts.opposed, compared = counts.compared;
        found.compare_signs(candidates_, sq_radius, counts);
        counts.looked_at += n;
        if (counts.opposed - opposed <= kFewOpposed * (counts.compared - compared)) return;
        for (std::size_t k = 0; k < n; ++k) counts.on_seams += is_on_seam(own, k, sq_radius);
    }

    /// Whether the k-th lies at a line on one side of which normals agree with its own, on the
    /// other oppose it.
    bool is_on_seam(const LocalBucket& own, std::size_t k, float sq_radius) const {
        const Vec3f p{own.x[k], own.y[k], own.z[k]}, n{own.nx[k], own.ny[k], own.nz[k]};
        SeamSides<float> sides;
        for (std::size_t c = 0; c < candidates_.n; ++c) {
            const Vec3f d = Vec3f{candidates_.x[c], candidates_.y[c], candidates_.z[c]} - p;
            const float sq = sq_length(d);
            if (!(sq > 0 && sq < sq_radius)) continue;
            const float cosine =
                dot(n, Vec3f{candidates_.nx[c], candidates_.ny[c], candidates_.nz[c]});
            if (std::abs(cosine) < kAlongOneLine) continue;
            sides.add(d, cosine > 0);
        }
        return sides.have(kFewestOfSide) && sides.lie_apart(sq_radius);
    }

    /// What the neighbours of the k-th say of its sign, -1 to 1: the votes of notes/0002, near ones
    /// first. The other wall of a crease, or side of a thin sheet, which may be the majority, says
    /// little: it lies across (notes/0003).
    double votes_for(const LocalBucket& own, std::size_t k, float sq_radius) const {
        const Vec3f p{own.x[k], own.y[k], own.z[k]}, n{own.nx[k], own.ny[k], own.nz[k]};
        float sum = 0, size = 0;
        for (std::size_t c = 0; c < candidates_.n; ++c) {
            const Vec3f d = Vec3f{candidates_.x[c], candidates_.y[c], candidates_.z[c]} - p;
            const float sq = sq_length(d);
            if (!(sq > 0 && sq < sq_radius)) continue;
            const Vec3f m{candidates_.nx[c], candidates_.ny[c], candidates_.nz[c]};
            const float vote = sign_vote(m, n, d, sq);
            const float weight = std::abs(vote) / (sq / sq_radius + kNear);
            sum += weight * vote;
            size += std::abs(weight * vote);
        }
        return size > 0 ? sum / size : 0;
    }

    /// mean: of the normals about point i; is_right: a closer look that few need
    template <class IsRight>
    void judge(std::size_t i, const Vec3d& mean, const IsRight& is_right) {
        if (!judged_.empty() && !judged_[i]) return;
        const Vec3f own = points_.normal[i];
        if (!(sq_length(own) > 0)) {
            ++counts.missing;
            return;
        }
        const double agreement = length(mean);
        if (!(agreement > 0)) return;
        const double cosine = dot(normalized(to_double(own)), mean) / agreement;
        const bool counts_too = counted_.empty() || counted_[i];
        counts.noisy +=
            counts_too && agreement > kClear && cosine < kNoisyNormal && cosine > kContrary;
        if (agreement < kMajority || cosine > kContrary || is_right()) return;
        counts.contrary += counts_too;
        mended.push_back({i, to_float(mean / agreement)});
    }

    const PointBlock& points_;
    const Neighborhoods& all_;
    double most_radius_;
    const std::vector<bool>& counted_;
    const std::vector<bool>& judged_;
    Surroundings around_;
    Candidates candidates_;
};

void add(const NormalAudit& one, NormalAudit& sum) {
    sum.missing += one.missing;
    sum.contrary += one.contrary;
    sum.noisy += one.noisy;
    sum.opposed += one.opposed;
    sum.compared += one.compared;
    sum.across += one.across;
    sum.across_size += one.across_size;
    sum.on_seams += one.on_seams;
    sum.looked_at += one.looked_at;
}

}  // namespace

NormalAudit repair_contrary_normals(PointBlock& points, const BoxTree& boxes,
                                    const std::vector<bool>& counted,
                                    const std::vector<bool>& judged) {
    SLIM_CHECK(boxes.size(), ==, points.size());
    const Neighborhoods all(points, boxes);
    const double most_radius = usual_diagonal(all.tree);
    std::vector<NormalAudit> partial((points.size() + kGrain - 1) / kGrain);
    std::vector<std::vector<Mended>> mended(partial.size());
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Auditor auditor(points, all, most_radius, counted, judged);
        for (std::size_t first = begin; first < end; first += kShared)
            auditor.audit(first, std::min(first + kShared, end));
        partial[begin / kGrain] = auditor.counts;
        mended[begin / kGrain] = std::move(auditor.mended);
    });
    for (const std::vector<Mended>& some : mended)
        for (const Mended& m : some) points.normal[m.point] = m.normal;
    NormalAudit audit;
    audit.n = points.size();
    for (const NormalAudit& p : partial) add(p, audit);
    return audit;
}

}  // namespace slim
