#include "slim/normals/repair.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/base/unfilled_vector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kMajority = 0.5;   // |mean normal| of neighbours that agree among themselves
constexpr double kContrary = -0.3;  // cosine to the majority below which a normal is wrong
constexpr double kClear = 0.7;      // |mean normal| that leaves no doubt
constexpr double kNoisy = 0.3;      // the height-field limit of the radius ladder
constexpr float kLeastNeighbors = 5;
// A bucket agrees by itself where |mean normal| and the least cosine to the mean of the others are at least
constexpr float kOfOneMind = 0.8f, kClose = 0.5f;
// |cosine| of normals that are the same but for the sign
constexpr float kAlongOneLine = 0.7f;
constexpr std::size_t kSampledBuckets = 16;  // of one in so many all pairs are compared
constexpr float kNowhere = 1e30f;  // of padding: in no ball

constexpr std::size_t kBucket = BoxTree::kBucket;
constexpr std::size_t kShared = kBucket * BoxTree::kFanout;  // points that share a walk of the tree
constexpr std::size_t kGrain = 4096;                         // points a task
static_assert(kGrain % kShared == 0);

/// A bucket's points relative to the low corner of its box, and their normals, as flat arrays:
/// ready to be moved to the origin of any bucket near.
struct alignas(64) LocalBucket {
    float x[kBucket], y[kBucket], z[kBucket], nx[kBucket], ny[kBucket], nz[kBucket];

    void set(const PointBlock& points, std::size_t begin, std::size_t end, const Vec3d& corner) {
        for (std::size_t k = 0; k < kBucket; ++k) {
            const bool is_point = begin + k < end;
            const Vec3f p =
                is_point ? to_float(points.position[begin + k] - corner) : Vec3f{kNowhere};
            const Vec3f n = is_point ? points.normal[begin + k] : Vec3f{};
            x[k] = p.x, y[k] = p.y, z[k] = p.z;
            nx[k] = n.x, ny[k] = n.y, nz[k] = n.z;
        }
    }
};

/// Whether all points of a full bucket face as the mean of the others in it does, and clearly: no look at what lies around is
/// needed (notes/0001).
[[gnu::flatten]] bool is_of_one_mind(const LocalBucket& b) {
    FloatV sum[3] = {0, 0, 0};
    for (std::size_t k = 0; k < kBucket; k += kLanes) {
        sum[0] += FloatV(b.nx + k, stdx::element_aligned);
        sum[1] += FloatV(b.ny + k, stdx::element_aligned);
        sum[2] += FloatV(b.nz + k, stdx::element_aligned);
    }
    const float x = stdx::reduce(sum[0]), y = stdx::reduce(sum[1]), z = stdx::reduce(sum[2]);
    constexpr float kLeast = kOfOneMind * kBucket;
    if (!(x * x + y * y + z * z > kLeast * kLeast)) return false;
    for (std::size_t k = 0; k < kBucket; k += kLanes) {
        const FloatV nx(b.nx + k, stdx::element_aligned), ny(b.ny + k, stdx::element_aligned), nz(b.nz + k, stdx::element_aligned);
        const FloatV mx = x - nx, my = y - ny, mz = z - nz;
        const FloatV along = mx * nx + my * ny + mz * nz;
        const FloatV sq_own = nx * nx + ny * ny + nz * nz, sq_mean = mx * mx + my * my + mz * mz;
        if (!stdx::all_of(along > FloatV(0) && along * along > FloatV(kClose * kClose) * sq_own * sq_mean)) return false;
    }
    return true;
}

/// The points of an audit: tree and local buckets. 24 bytes a point.
struct Neighborhoods {
    const BoxTree& tree;
    UnfilledVector<LocalBucket> buckets;

    Neighborhoods(const PointBlock& points, const BoxTree& boxes)
        : tree(boxes), buckets(tree.n_buckets()) {
        parallel_blocks(buckets.size(), kGrain / kBucket, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b)
                buckets[b].set(points, b * kBucket, std::min((b + 1) * kBucket, points.size()),
                               tree.bucket(b).lo);
        });
    }
};

constexpr std::size_t kGroups = kBucket / kLanes;  // of lanes that hold a bucket
static_assert(kBucket % kLanes == 0);

using BucketLanes = std::array<FloatV, kGroups>;

FloatV lanes_at(const float* values) { return FloatV(values, stdx::element_aligned); }

BucketLanes lanes_of(const float (&values)[kBucket]) {
    BucketLanes out;
    for (std::size_t g = 0; g < kGroups; ++g) out[g] = lanes_at(values + g * kLanes);
    return out;
}

/// Gaps between [lo, hi] and intervals side by side; zero where they meet.
FloatV gap(const FloatV& lo, const FloatV& hi, float from, float to) {
    return stdx::max(stdx::max(lo - to, from - hi), FloatV(0));
}

/// A box in floats, relative to an origin near it.
struct LocalBox {
    Vec3f lo, hi;
};

/// The buckets around some points: found with one walk for up to eight buckets of them.
class Surroundings {
public:
    void gather(const Neighborhoods& all, const Bbox& box, double radius) {
        n_ = 0;
        origin_ = box.lo;
        margin_ = static_cast<float>(kRounding * (box.diagonal() + radius));
        all.tree.for_buckets_near(box, radius, [&](std::size_t begin, std::size_t) {
            if (n_ + kLanes > bucket_.size()) grow();
            const LocalBox near = local(all.tree.bucket(begin / kBucket));
            bucket_[n_] = static_cast<std::uint32_t>(begin / kBucket);
            for (std::size_t axis = 0; axis < 3; ++axis)
                lo_[axis][n_] = near.lo[axis], hi_[axis][n_] = near.hi[axis];
            ++n_;
        });
        for (std::size_t k = n_; k % kLanes != 0; ++k) lo_[0][k] = hi_[0][k] = kNowhere;
    }

    /// Calls body(bucket) for every bucket whose box is nearer to a part of the box than the
    /// radius, in order; for some that are as far but for rounding, too.
    template <class Body>
    void for_buckets_near(const Bbox& part, double radius, Body&& body) const {
        const LocalBox box = local(part);
        const float reach = static_cast<float>(radius) + margin_;
        for (std::size_t first = 0; first < n_; first += kLanes)
            for (std::uint64_t bits = near_bits(first, box, reach * reach); bits != 0;
                 bits &= bits - 1)
                body(bucket_[first + static_cast<std::size_t>(std::countr_zero(bits))]);
    }

private:
    static constexpr double kRounding = 1e-6;  // of floats, with room to spare

    /// Which of the boxes from the first on are near.
    [[gnu::flatten]] std::uint64_t near_bits(std::size_t first, const LocalBox& box,
                                             float sq_reach) const {
        FloatV sq = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const FloatV d = gap(lanes_at(&lo_[axis][first]), lanes_at(&hi_[axis][first]),
                                 box.lo[axis], box.hi[axis]);
            sq += d * d;
        }
        return lane_bits(sq < FloatV(sq_reach));
    }
    LocalBox local(const Bbox& box) const {
        return {to_float(box.lo - origin_), to_float(box.hi - origin_)};
    }
    void grow() {
        bucket_.resize(2 * bucket_.size() + 256);
        for (auto* a : {&lo_, &hi_})
            for (std::vector<float>& values : *a) values.resize(bucket_.size());
    }

    Vec3d origin_;
    float margin_ = 0;
    std::vector<std::uint32_t> bucket_;
    std::array<std::vector<float>, 3> lo_, hi_;  // padded with boxes that are nowhere
    std::size_t n_ = 0;
};

/// The points nearer to a box than the radius, relative to its low corner, as flat arrays.
struct Candidates {
    std::vector<float> x, y, z, nx, ny, nz;
    std::size_t n = 0;

    void clear() { n = 0; }

    /// shift: of the bucket's corner from the box's; extent: of the box
    [[gnu::flatten]] void add(const LocalBucket& bucket, const Vec3f& shift, const Vec3f& extent,
                              float sq_radius) {
        if (n + kBucket > x.size()) grow();
        for (std::size_t k = 0; k < kBucket; k += kLanes) {
            const FloatV px = lanes_at(bucket.x + k) + shift.x,
                         py = lanes_at(bucket.y + k) + shift.y,
                         pz = lanes_at(bucket.z + k) + shift.z;
            const FloatV dx = gap(px, px, 0, extent.x), dy = gap(py, py, 0, extent.y),
                         dz = gap(pz, pz, 0, extent.z);
            const std::uint64_t near = lane_bits(dx * dx + dy * dy + dz * dz < FloatV(sq_radius));
            compress_to(px, near, &x[n]), compress_to(py, near, &y[n]),
                compress_to(pz, near, &z[n]);
            compress_to(lanes_at(bucket.nx + k), near, &nx[n]);
            compress_to(lanes_at(bucket.ny + k), near, &ny[n]);
            compress_to(lanes_at(bucket.nz + k), near, &nz[n]);
            n += static_cast<std::size_t>(std::popcount(near));
        }
    }

private:
    void grow() {
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz}) a->resize(2 * a->size() + 512);
    }
};

/// Points of one bucket, a lane each, and what they find of the candidates within a radius. A
/// candidate is looked at by all of them at once: most are near to most.
struct Sixteen {
    BucketLanes x, y, z, nx, ny, nz;
    BucketLanes sum_x{}, sum_y{}, sum_z{}, count{};  // of normals within the radius

    explicit Sixteen(const LocalBucket& points)
        : x(lanes_of(points.x)), y(lanes_of(points.y)), z(lanes_of(points.z)),
          nx(lanes_of(points.nx)), ny(lanes_of(points.ny)), nz(lanes_of(points.nz)) {}

    [[gnu::flatten]] void sum_up(const Candidates& c, float sq_radius) {
        const FloatV zero = 0, one = 1;
        for (std::size_t g = 0; g < kGroups; ++g) {
            // Copies, as the compiler keeps them in registers.
            const FloatV px = x[g], py = y[g], pz = z[g];
            FloatV sx = 0, sy = 0, sz = 0, n = 0;
            for (std::size_t k = 0; k < c.n; ++k) {
                const FloatV dx = c.x[k] - px, dy = c.y[k] - py, dz = c.z[k] - pz;
                const FloatV in =
                    select(dx * dx + dy * dy + dz * dz < FloatV(sq_radius), one, zero);
                sx += in * c.nx[k], sy += in * c.ny[k], sz += in * c.nz[k];
                n += in;
            }
            sum_x[g] = sx, sum_y[g] = sy, sum_z[g] = sz, count[g] = n;
        }
    }

    /// Bit k: the normal of the k-th is within 72 degrees of the mean of the others, by more than
    /// rounding: nothing is wrong with it.
    [[gnu::flatten]] std::uint64_t agreeing() const {
        constexpr float kAgree = static_cast<float>(kNoisy) + 0.01f;
        std::uint64_t bits = 0;
        for (std::size_t g = 0; g < kGroups; ++g) {
            const FloatV mx = sum_x[g] - nx[g], my = sum_y[g] - ny[g], mz = sum_z[g] - nz[g];
            const FloatV along = mx * nx[g] + my * ny[g] + mz * nz[g];
            const FloatV sq_own = nx[g] * nx[g] + ny[g] * ny[g] + nz[g] * nz[g];
            const FloatV sq_mean = mx * mx + my * my + mz * mz;
            bits |= lane_bits(along > FloatV(0) &&
                              along * along > FloatV(kAgree * kAgree) * sq_own * sq_mean)
                    << (g * kLanes);
        }
        return bits;
    }

    [[gnu::flatten]] void compare_signs(const Candidates& c, float sq_radius,
                                        NormalAudit& audit) const {
        const FloatV zero = 0, one = 1;
        for (std::size_t g = 0; g < kGroups; ++g) {
            FloatV opposed = 0, compared = 0, across = 0, across_size = 0;
            for (std::size_t k = 0; k < c.n; ++k) {
                const FloatV dx = c.x[k] - x[g], dy = c.y[k] - y[g], dz = c.z[k] - z[g];
                const auto in = dx * dx + dy * dy + dz * dz < FloatV(sq_radius);
                const FloatV cosine = nx[g] * c.nx[k] + ny[g] * c.ny[k] + nz[g] * c.nz[k];
                const FloatV height = nx[g] * dx + ny[g] * dy + nz[g] * dz;
                const auto is_opposed = in && cosine < FloatV(-kAlongOneLine);
                opposed += select(is_opposed, one, zero);
                compared += select(is_opposed || (in && cosine > FloatV(kAlongOneLine)), one, zero);
                across += select(is_opposed, height, zero);
                across_size += select(is_opposed, stdx::abs(height), zero);
            }
            audit.opposed += stdx::reduce(opposed);
            audit.compared += stdx::reduce(compared);
            audit.across += stdx::reduce(across);
            audit.across_size += stdx::reduce(across_size);
        }
    }

    /// Mean of the normals within the radius of the k-th, its own left out; zero if they are too
    /// few.
    Vec3d majority(std::size_t k) const {
        const std::size_t g = k / kLanes, lane = k % kLanes;
        const float n = count[g][lane];
        if (n < kLeastNeighbors + 1) return {};
        const Vec3d sum{sum_x[g][lane], sum_y[g][lane], sum_z[g][lane]};
        const Vec3d own{nx[g][lane], ny[g][lane], nz[g][lane]};
        return (sum - own) / static_cast<double>(n - 1);
    }
};

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
            const std::vector<bool>& counted)
        : points_(points), all_(all), most_radius_(most_radius), counted_(counted) {}

    /// Points [begin, end), whole buckets but for the last. Those that lie far from each other on
    /// either side of a jump of the curve are taken in parts.
    void audit(std::size_t begin, std::size_t end) {
        const Bbox box = box_of(begin, end);
        const std::size_t n_buckets = (end - begin + kBucket - 1) / kBucket;
        if (n_buckets > 1 && box.diagonal() > kCompact * most_radius_) {
            const std::size_t middle = begin + n_buckets / 2 * kBucket;
            audit(begin, middle);
            return audit(middle, end);
        }
        bool is_gathered = false;
        for (std::size_t first = begin; first < end; first += kBucket) {
            if (is_plain(first / kBucket)) continue;
            if (!std::exchange(is_gathered, true)) around_.gather(all_, box, most_radius_);
            audit_part(first, std::min(first + kBucket, end));
        }
    }

    NormalAudit counts;
    std::vector<Mended> mended;

private:
    static constexpr double kCompact = 8;

    /// Whether a bucket needs no closer look: compact, of one mind, and none of those whose pairs are compared.
    bool is_plain(std::size_t bucket) const {
        return bucket % kSampledBuckets != 0 && (bucket + 1) * kBucket <= points_.size() &&
               all_.tree.bucket(bucket).diagonal() <= 2 * most_radius_ && is_of_one_mind(all_.buckets[bucket]);
    }
    Bbox box_of(std::size_t begin, std::size_t end) const {
        Bbox box;
        for (std::size_t i = begin; i < end; ++i) box.extend(points_.position[i]);
        return box;
    }

    /// Points of one bucket; in parts, too.
    void audit_part(std::size_t begin, std::size_t end) {
        const Bbox box = box_of(begin, end);
        if (end - begin > 1 && box.diagonal() > 2 * most_radius_) {
            const std::size_t middle = (begin + end) / 2;
            audit_part(begin, middle);
            return audit_part(middle, end);
        }
        const std::size_t bucket = begin / kBucket;
        const double radius = std::min(0.5 * all_.tree.bucket(bucket).diagonal(), most_radius_);
        LocalBucket own;
        own.set(points_, begin, end, box.lo);
        Sixteen found(own);
        const auto sq_radius = static_cast<float>(radius) * static_cast<float>(radius);
        candidates_.clear();
        around_.for_buckets_near(box, radius, [&](std::size_t b) {
            candidates_.add(all_.buckets[b], to_float(all_.tree.bucket(b).lo - box.lo),
                            to_float(box.extent()), sq_radius);
        });
        found.sum_up(candidates_, sq_radius);
        if (bucket % kSampledBuckets == 0) found.compare_signs(candidates_, sq_radius, counts);
        const std::uint64_t agreeing = found.agreeing();
        for (std::size_t k = 0; k < end - begin; ++k)
            if ((agreeing >> k & 1) == 0) judge(begin + k, found.majority(k));
    }

    /// mean: of the normals about point i
    void judge(std::size_t i, const Vec3d& mean) {
        const Vec3f own = points_.normal[i];
        if (!(sq_length(own) > 0)) {
            ++counts.missing;
            return;
        }
        const double agreement = length(mean);
        if (!(agreement > 0)) return;
        const double cosine = dot(normalized(to_double(own)), mean) / agreement;
        const bool counts_too = counted_.empty() || counted_[i];
        counts.noisy += counts_too && agreement > kClear && cosine < kNoisy && cosine > kContrary;
        if (agreement < kMajority || cosine > kContrary) return;
        counts.contrary += counts_too;
        mended.push_back({i, to_float(mean / agreement)});
    }

    const PointBlock& points_;
    const Neighborhoods& all_;
    double most_radius_;
    const std::vector<bool>& counted_;
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
}

}  // namespace

NormalAudit repair_contrary_normals(PointBlock& points, const BoxTree& boxes,
                                    const std::vector<bool>& counted) {
    SLIM_CHECK(boxes.size(), ==, points.size());
    const Neighborhoods all(points, boxes);
    const double most_radius = usual_diagonal(all.tree);
    std::vector<NormalAudit> partial((points.size() + kGrain - 1) / kGrain);
    std::vector<std::vector<Mended>> mended(partial.size());
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Auditor auditor(points, all, most_radius, counted);
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
