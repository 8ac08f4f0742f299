#include "slim/smooth/surface_samples.h"

#include "slim/base/parallel.h"
#include "slim/blend/blend.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr std::size_t kGrain = 64;
constexpr double kLeast = 4;                                 // samples of a leaf
constexpr double kTurn = std::numbers::pi * (3 - 2.2360679774997896964);  // golden angle

double core_area(double radius) { return std::numbers::pi * (kTrim * radius) * (kTrim * radius); }

/// In how many cores of the same side a point lies; at least 1, its own.
int cores_at(const Vec3d& p, const Vec3d& normal, const std::vector<const Surfel*>& supporters) {
    int n = 0;
    for (const Surfel* s : supporters) {
        const double core = kTrim * s->support_radius;
        n += sq_length(p - s->center) < core * core && dot(s->frame.normal, normal) > 0 ? 1 : 0;
    }
    return std::max(n, 1);
}

/// Samples one leaf at `n` seeds.
void sample_leaf(const Surfel& leaf, std::size_t n, const BallIndex& index,
                 std::vector<const Surfel*>& found, std::vector<SurfaceSample>& out) {
    const double radius = leaf.support_radius, share = core_area(radius) / static_cast<double>(n);
    const Vec3d down = -leaf.frame.normal;
    for (std::size_t k = 0; k < n; ++k) {
        const double r = kTrim * std::sqrt((static_cast<double>(k) + 0.5) / static_cast<double>(n));
        const double angle = static_cast<double>(k) * kTurn;
        const Vec3d seed =
            leaf.frame.world_from_local({r * std::cos(angle), r * std::sin(angle), 1.0});
        const Ray ray{leaf.center + seed * radius, down};
        Vec3d gradient;
        const auto t = first_hit(ray, leaf, 0, kTrim, gradient);
        if (!t) continue;
        const Vec3d hit = ray.origin + down * *t;
        index.supporters(hit, found);
        const auto put = project_along(hit, leaf.frame.normal, found);
        if (!put) continue;
        const double slant = std::max(0.1, dot(put->normal, leaf.frame.normal));
        out.push_back({put->point, put->normal, share / slant / cores_at(hit, put->normal, found)});
    }
}

}  // namespace

std::vector<SurfaceSample> sample_surface(const SurfelTree& tree, const BallIndex& index,
                                          std::size_t n_wanted) {
    std::vector<std::size_t> leaves;
    double area = 0;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf() && !tree.node(i).is_loose()) {
            leaves.push_back(i);
            area += core_area(tree.support_radius(i));
        }
    std::vector<std::vector<SurfaceSample>> parts((leaves.size() + kGrain - 1) / kGrain);
    parallel_blocks(leaves.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end; ++i) {
            const Surfel leaf = tree.surfel(leaves[i]);
            const double n =
                static_cast<double>(n_wanted) * core_area(leaf.support_radius) / area;
            sample_leaf(leaf, static_cast<std::size_t>(std::max(kLeast, std::round(n))), index,
                        found, parts[begin / kGrain]);
        }
    });
    std::vector<SurfaceSample> out;
    for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
    return out;
}

}  // namespace slim
