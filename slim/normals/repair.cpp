#include "slim/normals/repair.h"

#include "slim/base/parallel.h"
#include "slim/base/simd.h"
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
constexpr float kNowhere = 1e30f;  // of padding: in no ball
constexpr std::size_t kGrain = 256;  // buckets a task

/// The points around one bucket, relative to its first point: found once for its sixteen.
struct Surroundings {
    std::vector<float> x, y, z, nx, ny, nz;
    std::size_t n = 0;  // of the arrays' first; whole lanes, padded with points that are in no ball

    void gather(const PointBlock& points, const BoxTree& tree, const Bbox& box, double radius) {
        n = 0;
        const Vec3d origin = box.lo;
        tree.for_buckets_near(box, radius, [&](std::size_t begin, std::size_t end) {
            if (n + BoxTree::kBucket + kLanes > x.size()) grow();
            for (std::size_t i = begin; i < end; ++i, ++n) {
                const Vec3f p = to_float(points.position[i] - origin);
                x[n] = p.x, y[n] = p.y, z[n] = p.z;
                const Vec3f& m = points.normal[i];
                nx[n] = m.x, ny[n] = m.y, nz[n] = m.z;
            }
        });
        for (; n % kLanes != 0; ++n) {
            x[n] = kNowhere;
            nx[n] = ny[n] = nz[n] = 0;
        }
    }

private:
    void grow() {
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz}) a->resize(2 * a->size() + 256);
    }
};

/// Mean of the normals within a radius of p, the point's own (`own`) left out; zero if they are too few.
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

/// A bucket that straddles a jump of the curve is as large as the jump: its radius would gather thousands of
/// points. Twice the median serves all but the sparsest 1 %.
double usual_diagonal(const BoxTree& tree) {
    std::vector<double> diagonals(tree.n_buckets());
    for (std::size_t b = 0; b < diagonals.size(); ++b) diagonals[b] = tree.bucket(b).diagonal();
    if (diagonals.empty()) return 0;
    const auto middle = diagonals.begin() + static_cast<std::ptrdiff_t>(diagonals.size() / 2);
    std::nth_element(diagonals.begin(), middle, diagonals.end());
    return *middle;
}

/// Looks at points [begin, end) of a bucket, whose surroundings hold all within the radius; those that are
/// mended go to `mended`.
void audit_points(const PointBlock& points, std::size_t begin, std::size_t end, const Vec3d& origin,
                  double radius, const Surroundings& around, std::vector<Vec3f>& mended,
                  NormalAudit& audit) {
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3f own = points.normal[i];
        if (!(sq_length(own) > 0)) {
            ++audit.missing;
            continue;
        }
        const Vec3d mean = majority(around, to_float(points.position[i] - origin), own,
                                    static_cast<float>(radius));
        const double agreement = length(mean);
        if (!(agreement > 0)) continue;
        const double cosine = dot(normalized(to_double(own)), mean) / agreement;
        if (agreement > kClear && cosine < kNoisy && cosine > kContrary) ++audit.noisy;
        if (agreement < kMajority || cosine > kContrary) continue;
        ++audit.contrary;
        mended[i] = to_float(mean / agreement);
    }
}

void audit_bucket(const PointBlock& points, const BoxTree& tree, std::size_t bucket,
                  double most_radius, Surroundings& around, std::vector<Vec3f>& mended,
                  NormalAudit& audit) {
    const std::size_t begin = bucket * BoxTree::kBucket;
    const std::size_t end = std::min(begin + BoxTree::kBucket, tree.size());
    const Bbox& box = tree.bucket(bucket);
    const double radius = std::min(0.5 * box.diagonal(), most_radius);
    // A bucket that straddles a jump is served point by point.
    const bool compact = box.diagonal() <= 2 * most_radius;
    if (compact) {
        around.gather(points, tree, box, radius);
        return audit_points(points, begin, end, box.lo, radius, around, mended, audit);
    }
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3d& p = points.position[i];
        around.gather(points, tree, {p, p}, radius);
        audit_points(points, i, i + 1, p, radius, around, mended, audit);
    }
}

}  // namespace

NormalAudit repair_contrary_normals(PointBlock& points) {
    const BoxTree tree(points.size(), [&](std::size_t i) { return points.position[i]; });
    const double most_radius = usual_diagonal(tree);
    std::vector<Vec3f> mended = points.normal;
    std::vector<NormalAudit> partial((tree.n_buckets() + kGrain - 1) / kGrain);
    parallel_blocks(tree.n_buckets(), kGrain, [&](std::size_t begin, std::size_t end) {
        Surroundings around;
        for (std::size_t bucket = begin; bucket < end; ++bucket)
            audit_bucket(points, tree, bucket, most_radius, around, mended, partial[begin / kGrain]);
    });
    points.normal = std::move(mended);
    NormalAudit audit;
    audit.n = points.size();
    for (const NormalAudit& p : partial) {
        audit.missing += p.missing;
        audit.contrary += p.contrary;
        audit.noisy += p.noisy;
    }
    return audit;
}

}  // namespace slim
