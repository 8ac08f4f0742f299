#include "slim/normals/repair.h"

#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/neighbors/point_tree.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr double kMajority = 0.5;   // |mean normal| of neighbours that agree among themselves
constexpr double kContrary = -0.3;  // cosine to the majority below which a normal is wrong
constexpr double kClear = 0.7;      // |mean normal| that leaves no doubt
constexpr double kNoisy = 0.3;      // the height-field limit of the radius ladder
constexpr float kLeastNeighbors = 5;
constexpr float kNowhere = 1e30f;  // of padding: in no ball
constexpr std::size_t kGrain = 4096;

/// The points around one bucket, relative to its first point: found once for its sixteen.
struct Surroundings {
    std::vector<float> x, y, z, nx, ny, nz;

    void gather(const PointTree& tree, const Vec3d& origin, const Vec3d& center, double radius) {
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz}) a->clear();
        tree.for_buckets_in_ball(center, radius, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3f p = to_float(tree.position(i) - origin);
                x.push_back(p.x), y.push_back(p.y), z.push_back(p.z);
                const Vec3f n = tree.normal(i);
                nx.push_back(n.x), ny.push_back(n.y), nz.push_back(n.z);
            }
        });
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz})
            a->resize((a->size() + kLanes - 1) / kLanes * kLanes, a == &x ? kNowhere : 0.0f);
    }
};

/// Mean of the normals within a radius of p, the point's own (`own`) left out; zero if they are too few.
Vec3d majority(const Surroundings& s, const Vec3f& p, const Vec3f& own, float radius) {
    FloatV sum_x = 0, sum_y = 0, sum_z = 0, count = 0;
    const auto lanes = [](const std::vector<float>& a, std::size_t k) {
        return FloatV(&a[k], stdx::element_aligned);
    };
    for (std::size_t k = 0; k < s.x.size(); k += kLanes) {
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
double usual_diagonal(const PointTree& tree) {
    std::vector<double> diagonals;
    for (std::size_t i = 0; i < tree.size(); i += PointTree::kBucket)
        diagonals.push_back(tree.bucket_diagonal(i));
    if (diagonals.empty()) return 0;
    const auto middle = diagonals.begin() + static_cast<std::ptrdiff_t>(diagonals.size() / 2);
    std::nth_element(diagonals.begin(), middle, diagonals.end());
    return *middle;
}

/// Looks at the points of one bucket and mends `points`; neighbours are read from the tree's own copy, so the
/// order of repairs does not matter.
void audit_bucket(const PointTree& tree, std::size_t begin, double most_radius,
                  Surroundings& around, PointBlock& points, NormalAudit& audit) {
    const std::size_t end = std::min(begin + PointTree::kBucket, tree.size());
    const double radius = std::min(0.5 * tree.bucket_diagonal(begin), most_radius);
    const Vec3d origin = tree.position(begin);
    Bbox box;
    for (std::size_t i = begin; i < end; ++i) box.extend(tree.position(i));
    // A bucket that straddles a jump is served point by point.
    const bool compact = box.diagonal() <= 2 * most_radius;
    if (compact) around.gather(tree, origin, box.center(), 0.5 * box.diagonal() + radius);
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3f own = tree.normal(i);
        if (!(sq_length(own) > 0)) {
            ++audit.missing;
            continue;
        }
        if (!compact) around.gather(tree, origin, tree.position(i), radius);
        const Vec3d mean = majority(around, to_float(tree.position(i) - origin), own,
                                    static_cast<float>(radius));
        const double agreement = length(mean);
        if (!(agreement > 0)) continue;
        const double cosine = dot(normalized(to_double(own)), mean) / agreement;
        if (agreement > kClear && cosine < kNoisy && cosine > kContrary) ++audit.noisy;
        if (agreement < kMajority || cosine > kContrary) continue;
        ++audit.contrary;
        points.normal[tree.source(i)] = to_float(mean / agreement);
    }
}

}  // namespace

NormalAudit repair_contrary_normals(PointBlock& points) {
    Bbox box;
    for (const Vec3d& p : points.position) box.extend(p);
    const PointTree tree(points, morton_order(points, box));
    const double most_radius = usual_diagonal(tree);
    std::vector<NormalAudit> partial((tree.size() + kGrain - 1) / kGrain);
    parallel_blocks(tree.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Surroundings around;
        NormalAudit& audit = partial[begin / kGrain];
        audit.n = end - begin;
        for (std::size_t bucket = begin; bucket < end; bucket += PointTree::kBucket)
            audit_bucket(tree, bucket, most_radius, around, points, audit);
    });
    NormalAudit audit;
    for (const NormalAudit& p : partial) {
        audit.n += p.n;
        audit.missing += p.missing;
        audit.contrary += p.contrary;
        audit.noisy += p.noisy;
    }
    return audit;
}

}  // namespace slim
