#pragma once

#include "slim/blend/blend.h"
#include "slim/cover/level_cover.h"
#include "slim/fit/noise_variance.h"
#include "slim/shapes/shape.h"
#include "slim/tree/ball_index.h"
#include "slim/tree/tree_builder.h"
#include "tests/slim/extremes/third_order.h"
#include "tests/slim/fit/fit_support.h"
#include "tests/slim/fit/noise_support.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace slim::test {

/// n points of a shape in the tangent disc of `radius` about a point of it: exact to rounding,
/// normals with them. The shape must be a height field there.
inline PointBlock patch_of(const Shape& shape, const Vec3d& at, double radius, std::size_t n,
                           std::uint64_t seed) {
    const Frame<double> f = frame_from_normal(surface_point(shape.jet(at)).normal);
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t k = 0; positions.size() < n; ++k) {
        const double u = random_at(seed, 2 * k), v = random_at(seed, 2 * k + 1);
        if (u * u + v * v > 1) continue;
        Vec3d p = at + (f.u_axis * u + f.v_axis * v) * radius;
        for (int i = 0; i < 20; ++i)  // Newton along the normal
            p -= f.normal * (shape.value(p) / dot(shape.jet(p).gradient(), f.normal));
        positions.push_back(p);
        normals.push_back(to_float(surface_point(shape.jet(p)).normal));
    }
    return block_of(std::move(positions), std::move(normals));
}

/// The surfel of one ball about a point of a shape, fitted to n exact points.
inline Surfel patch_surfel(const Shape& shape, const Vec3d& at, double radius, int degree,
                           std::size_t n = 1500, std::uint64_t seed = 1) {
    const PointBlock block = patch_of(shape, at, radius * 1.01, n, seed);
    BallPoints<double> work;
    return fit_surfel(tree_of(block), at, surface_point(shape.jet(at)).normal, radius, degree,
                      false, 0, work)
        .fitted.surfel;
}

/// What the pipeline's stages would choose for a block in doubles.
inline CoverRules usual_rules(const PointBlock& block, double mdl_threshold, int degree) {
    constexpr double epsilon = 2.220446049250313e-16;
    CoverRules rules;
    rules.degree = degree;
    rules.mdl_threshold = mdl_threshold;
    rules.diagonal = box_of(block).diagonal();
    rules.least_radius = rules.diagonal * epsilon;
    const double measured = robust_noise(measured_noise(block.position, 0, 10000)).variance;
    const double quantum = rules.diagonal * epsilon;
    rules.noise_variance = std::max(measured, 16 * quantum * quantum);
    return rules;
}

/// Root mean squares over the points that the model supports.
struct ModelErrors {
    double distance = 0, most = 0;  ///< of the points to the model along their normals
    double normal_deg = 0, k1 = 0, k2 = 0, mean = 0, gauss = 0;
    std::size_t missed = 0;
};

/// A model made in memory from points with normals: cover, tree and what finds its leaves.
class Built {
public:
    explicit Built(const PointBlock& block, double mdl_threshold = 0.01, int degree = 2)
        : Built(block, usual_rules(block, mdl_threshold, degree)) {}
    Built(const PointBlock& block, const CoverRules& rules)
        : rules_(rules),
          cover_(covered(block, rules)),
          tree_(linked(block)),
          index_(tree_.view()) {}

    const CoverRules& rules() const { return rules_; }
    const CoverCounts& counts() const { return cover_.counts; }
    const SurfelTreeData& tree() const { return tree_; }
    double leaf_count() const { return static_cast<double>(cover_.counts.leaves); }
    std::vector<FittedSurfel> leaves() const {
        std::vector<FittedSurfel> out;
        std::copy_if(cover_.surfels.begin(), cover_.surfels.end(), std::back_inserter(out),
                     [](const FittedSurfel& s) { return (s.flags & kLeaf) != 0; });
        return out;
    }
    double median_radius() const {
        std::vector<double> radii;
        for (const FittedSurfel& s : leaves()) radii.push_back(s.surfel.support_radius);
        const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
        std::nth_element(radii.begin(), middle, radii.end());
        return *middle;
    }
    /// RMS of eps over the leaves: what "within eps" means of a model.
    double mean_error() const {
        double sum = 0;
        for (const FittedSurfel& s : leaves()) sum += s.fit_error * s.fit_error;
        return std::sqrt(sum / leaf_count());
    }
    std::optional<Projection> project(const Vec3d& p, const Vec3d& normal) const {
        std::vector<const Surfel*> found;
        index_.supporters(p, found);
        return project_along(p, normal, found, true);
    }
    /// First hit of a ray with the leaves' trimmed balls: what stage 1 of the renderer draws.
    std::optional<double> ray_hit(const Vec3d& origin, const Vec3d& direction) const {
        std::optional<double> best;
        Vec3d gradient;
        for (const FittedSurfel& s : leaves_) {
            const auto t = first_hit(Ray{origin, direction}, s.surfel, 0, kHitTrim, gradient);
            if (t && dot(gradient, direction) < 0 && !(best && *best <= *t)) best = t;
        }
        return best;
    }
    /// Errors at the points of a cloud whose truth stands beside it.
    ModelErrors errors(const Cloud& cloud) const {
        ModelErrors e;
        const auto sq = [](double x) { return x * x; };
        for (std::size_t i = 0; i < cloud.size(); ++i) {
            const SurfacePoint& truth = cloud.truth[i];
            const auto hit = project(cloud.positions[i], truth.normal);
            if (!hit) {
                ++e.missed;
                continue;
            }
            e.distance += sq(hit->t), e.most = std::max(e.most, std::abs(hit->t));
            e.normal_deg += sq(length(cross(hit->normal, truth.normal)) * 180 / std::numbers::pi);
            e.k1 += sq(hit->curvature.k1 - truth.k1), e.k2 += sq(hit->curvature.k2 - truth.k2);
            e.mean += sq(hit->curvature.mean - (truth.k1 + truth.k2) / 2);
            e.gauss += sq(hit->curvature.gauss - truth.k1 * truth.k2);
        }
        const double n = static_cast<double>(cloud.size() - e.missed);
        for (double* value : {&e.distance, &e.normal_deg, &e.k1, &e.k2, &e.mean, &e.gauss})
            *value = std::sqrt(*value / n);
        return e;
    }

private:
    static Cover covered(const PointBlock& block, const CoverRules& rules) {
        Reporter silent;
        return cover_points(block, rules, silent);
    }
    SurfelTreeData linked(const PointBlock& block) {
        ModelHeader header;
        header.degree = rules_.degree;
        header.bounds = box_of(block);
        header.diagonal = rules_.diagonal;
        header.n_points = block.size();
        TreeCounts counts;
        leaves_ = leaves();
        return build_tree(cover_.surfels, header, counts);
    }

    CoverRules rules_;
    Cover cover_;
    std::vector<FittedSurfel> leaves_;
    SurfelTreeData tree_;
    BallIndex index_;
};

}  // namespace slim::test
