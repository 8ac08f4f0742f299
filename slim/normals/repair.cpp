#include "slim/normals/repair.h"

#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/base/unfilled_vector.h"
#include "slim/neighbors/box_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kMajority = 0.5;   // |mean normal| of neighbours that agree among themselves
constexpr double kContrary = -0.3;  // cosine to the majority below which a normal is wrong
constexpr double kClear = 0.7;      // |mean normal| that leaves no doubt
constexpr double kNoisy = 0.3;      // the height-field limit of the radius ladder
constexpr float kLeastNeighbors = 5;
constexpr float kAlongOneLine = 0.7f;        // |cosine| of normals that are the same but for the sign
constexpr std::size_t kSampledBuckets = 16;  // of one in so many all pairs are compared
constexpr float kNowhere = 1e30f;  // of padding: in no ball
constexpr std::size_t kGrain = 256;  // buckets a task

constexpr std::size_t kBucket = BoxTree::kBucket;

/// A bucket's points relative to the low corner of its box, and their normals, as flat arrays:
/// ready to be copied into the surroundings of every bucket near.
struct LocalBucket {
    float x[kBucket], y[kBucket], z[kBucket], nx[kBucket], ny[kBucket], nz[kBucket];

    void set(const PointBlock& points, std::size_t begin, std::size_t end, const Vec3d& corner) {
        for (std::size_t k = 0; k < kBucket; ++k) {
            const bool is_point = begin + k < end;
            const Vec3f p = is_point ? to_float(points.position[begin + k] - corner) : Vec3f{kNowhere};
            const Vec3f n = is_point ? points.normal[begin + k] : Vec3f{};
            x[k] = p.x, y[k] = p.y, z[k] = p.z;
            nx[k] = n.x, ny[k] = n.y, nz[k] = n.z;
        }
    }
};

/// The points of an audit: tree and local buckets. 28 bytes a point.
struct Neighborhoods {
    BoxTree tree;
    UnfilledVector<LocalBucket> buckets;

    explicit Neighborhoods(const PointBlock& points)
        : tree(points.size(), [&](std::size_t i) { return points.position[i]; }),
          buckets(tree.n_buckets()) {
        parallel_blocks(buckets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b)
                buckets[b].set(points, b * kBucket, std::min((b + 1) * kBucket, points.size()),
                               tree.bucket(b).lo);
        });
    }
};

/// The points around one bucket, relative to an origin: found once for its sixteen.
struct Surroundings {
    std::vector<float> x, y, z, nx, ny, nz;
    std::size_t n = 0;  // of the arrays' first; whole buckets, padded with points that are in no ball

    void gather(const Neighborhoods& all, const Bbox& box, double radius) {
        n = 0;
        const Vec3d origin = box.lo;
        all.tree.for_buckets_near(box, radius, [&](std::size_t begin, std::size_t) {
            if (n + kBucket > x.size()) grow();
            const LocalBucket& from = all.buckets[begin / kBucket];
            const Vec3f shift = to_float(all.tree.bucket(begin / kBucket).lo - origin);
            for (std::size_t k = 0; k < kBucket; ++k) {
                x[n + k] = from.x[k] + shift.x;
                y[n + k] = from.y[k] + shift.y;
                z[n + k] = from.z[k] + shift.z;
            }
            std::copy_n(from.nx, kBucket, &nx[n]);
            std::copy_n(from.ny, kBucket, &ny[n]);
            std::copy_n(from.nz, kBucket, &nz[n]);
            n += kBucket;
        });
    }

private:
    void grow() {
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz}) a->resize(2 * a->size() + 256);
    }
};
static_assert(kBucket % kLanes == 0);

/// Mean of the normals within a radius of p, the point's own (`own`) left out; zero if they are too
/// few.
Vec3d majority(const Surroundings& s, const Vec3f& p, const Vec3f& own, float radius) {
    FloatV sum_x = 0, sum_y = 0, sum_z = 0, count = 0;
    const auto lanes = [](const std::vector<float>& a, std::size_t k) {
        return FloatV(&a[k], stdx::element_aligned);
    };
    for (std::size_t k = 0; k < s.n; k += kLanes) {
        const FloatV dx = lanes(s.x, k) - p.x, dy = lanes(s.y, k) - p.y, dz = lanes(s.z, k) - p.z;
        const FloatV in = select(dx * dx + dy * dy + dz * dz < FloatV(radius * radius), FloatV(1),
                                 FloatV(0));
        sum_x += in * lanes(s.nx, k), sum_y += in * lanes(s.ny, k), sum_z += in * lanes(s.nz, k);
        count += in;
    }
    const Vec3d sum{stdx::reduce(sum_x), stdx::reduce(sum_y), stdx::reduce(sum_z)};
    const float n = stdx::reduce(count);
    if (n < kLeastNeighbors + 1) return {};
    return (sum - to_double(own)) / static_cast<double>(n - 1);
}

/// Compares the normal of a point at p with those within the radius.
void compare_signs(const Surroundings& s, const Vec3f& p, const Vec3f& own, float radius,
                   NormalAudit& audit) {
    FloatV opposed = 0, compared = 0, across = 0, across_size = 0;
    const FloatV zero = 0, one = 1;
    const auto lanes = [](const std::vector<float>& a, std::size_t k) {
        return FloatV(&a[k], stdx::element_aligned);
    };
    for (std::size_t k = 0; k < s.n; k += kLanes) {
        const FloatV dx = lanes(s.x, k) - p.x, dy = lanes(s.y, k) - p.y, dz = lanes(s.z, k) - p.z;
        const auto in = dx * dx + dy * dy + dz * dz < FloatV(radius * radius);
        const FloatV cosine =
            own.x * lanes(s.nx, k) + own.y * lanes(s.ny, k) + own.z * lanes(s.nz, k);
        const FloatV height = own.x * dx + own.y * dy + own.z * dz;
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

/// Looks at points [begin, end) of a bucket, whose surroundings hold all within the radius; those
/// that are mended go to `mended`.
void audit_points(const PointBlock& points, std::size_t begin, std::size_t end, const Vec3d& origin,
                  double radius, const Surroundings& around, const std::vector<bool>& counted,
                  std::vector<Mended>& mended, NormalAudit& audit) {
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3f own = points.normal[i];
        if (!(sq_length(own) > 0)) {
            ++audit.missing;
            continue;
        }
        const Vec3d mean = majority(around, to_float(points.position[i] - origin), own,
                                    static_cast<float>(radius));
        if (i / kBucket % kSampledBuckets == 0)
            compare_signs(around, to_float(points.position[i] - origin), own,
                          static_cast<float>(radius), audit);
        const double agreement = length(mean);
        if (!(agreement > 0)) continue;
        const double cosine = dot(normalized(to_double(own)), mean) / agreement;
        const bool counts = counted.empty() || counted[i];
        audit.noisy += counts && agreement > kClear && cosine < kNoisy && cosine > kContrary;
        if (agreement < kMajority || cosine > kContrary) continue;
        audit.contrary += counts;
        mended.push_back({i, to_float(mean / agreement)});
    }
}

/// Audits points [begin, end) with the neighbours within a radius. Points that straddle a jump of
/// the curve are taken in parts.
void audit_range(const PointBlock& points, const Neighborhoods& all, std::size_t begin, std::size_t end,
                 double radius, double most_radius, Surroundings& around,
                 const std::vector<bool>& counted, std::vector<Mended>& mended, NormalAudit& audit) {
    Bbox box;
    for (std::size_t i = begin; i < end; ++i) box.extend(points.position[i]);
    if (end - begin > 1 && box.diagonal() > 2 * most_radius) {
        const std::size_t middle = (begin + end) / 2;
        audit_range(points, all, begin, middle, radius, most_radius, around, counted, mended, audit);
        audit_range(points, all, middle, end, radius, most_radius, around, counted, mended, audit);
        return;
    }
    around.gather(all, box, radius);
    audit_points(points, begin, end, box.lo, radius, around, counted, mended, audit);
}

}  // namespace

NormalAudit repair_contrary_normals(PointBlock& points, const std::vector<bool>& counted) {
    const Neighborhoods all(points);
    const double most_radius = usual_diagonal(all.tree);
    std::vector<NormalAudit> partial((all.buckets.size() + kGrain - 1) / kGrain);
    std::vector<std::vector<Mended>> mended(partial.size());
    parallel_blocks(all.buckets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Surroundings around;
        for (std::size_t b = begin; b < end; ++b) {
            const std::size_t first = b * kBucket;
            const double radius = std::min(0.5 * all.tree.bucket(b).diagonal(), most_radius);
            audit_range(points, all, first, std::min(first + kBucket, points.size()), radius,
                        most_radius, around, counted, mended[begin / kGrain],
                        partial[begin / kGrain]);
        }
    });
    for (const std::vector<Mended>& some : mended)
        for (const Mended& m : some) points.normal[m.point] = m.normal;
    NormalAudit audit;
    audit.n = points.size();
    for (const NormalAudit& p : partial) {
        audit.missing += p.missing;
        audit.contrary += p.contrary;
        audit.noisy += p.noisy;
        audit.opposed += p.opposed;
        audit.compared += p.compared;
        audit.across += p.across;
        audit.across_size += p.across_size;
    }
    return audit;
}

}  // namespace slim
