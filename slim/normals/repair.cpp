#include "slim/normals/repair.h"

#include "slim/base/parallel.h"
#include "slim/neighbors/point_tree.h"

#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr double kMajority = 0.5;   // |mean normal| of neighbours that agree among themselves
constexpr double kContrary = -0.3;  // cosine to the majority below which a normal is wrong
constexpr double kClear = 0.7;      // |mean normal| that leaves no doubt
constexpr double kNoisy = 0.3;      // the height-field limit of the radius ladder
constexpr std::size_t kLeastNeighbors = 5;
constexpr std::size_t kGrain = 4096;

/// Mean of the neighbours' normals, the point's own left out; zero if there are too few.
Vec3d majority(const PointTree& tree, std::size_t i) {
    const Vec3d p = tree.position(i);
    const double radius = 0.5 * tree.bucket_diagonal(i);
    Vec3d sum;
    std::size_t n = 0;
    tree.for_buckets_in_ball(p, radius, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            if (k == i || !(sq_length(tree.position(k) - p) < radius * radius)) continue;
            sum += to_double(tree.normal(k));
            ++n;
        }
    });
    return n < kLeastNeighbors ? Vec3d{} : sum / static_cast<double>(n);
}

}  // namespace

NormalAudit repair_contrary_normals(PointBlock& points) {
    Bbox box;
    for (const Vec3d& p : points.position) box.extend(p);
    const PointTree tree(points, morton_order(points, box));
    const std::size_t n_blocks = (tree.size() + kGrain - 1) / kGrain;
    std::vector<NormalAudit> partial(n_blocks);
    parallel_blocks(tree.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        NormalAudit& audit = partial[begin / kGrain];
        audit.n = end - begin;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d own = to_double(tree.normal(i));
            if (!(sq_length(own) > 0)) {
                ++audit.missing;
                continue;
            }
            const Vec3d mean = majority(tree, i);
            const double agreement = length(mean);
            if (!(agreement > 0)) continue;
            const double cosine = dot(normalized(own), mean) / agreement;
            if (agreement > kClear && cosine < kNoisy && cosine > kContrary) ++audit.noisy;
            if (agreement < kMajority || cosine > kContrary) continue;
            ++audit.contrary;
            // Neighbours read the tree's copy: the order of repairs does not matter.
            points.normal[tree.source(i)] = to_float(mean / agreement);
        }
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
