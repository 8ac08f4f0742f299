#include "slim/cover/blend_refit.h"

#include "slim/base/parallel.h"
#include "slim/blend/blend.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

namespace slim::test {
namespace {

/// RMS distance of points to the blend of leaves, along their normals;
/// points that no leaf supports fail.
double rms_off(const PointBlock& points, const std::vector<FittedSurfel>& leaves) {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<const Surfel*> near;
        for (const FittedSurfel& s : leaves)
            if (sq_length(points.position[i] - s.surfel.center) <
                s.surfel.support_radius * s.surfel.support_radius)
                near.push_back(&s.surfel);
        const auto at = project_along(points.position[i], to_double(points.normal[i]), near);
        if (!at) {
            ADD_FAILURE() << "no support at point " << i;
            return INFINITY;
        }
        sum += at->t * at->t;
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
}

struct Pair {
    Cover once, twice;
};

Pair covers_of(const PointBlock& block, double mdl_threshold, int degree = 2) {
    CoverRules rules = rules_for(block, mdl_threshold, degree);
    rules.refits = true;
    Pair out;
    out.twice = cover(block, rules);
    rules.last_level = kLastLevel - 1;  // finer levels might come
    out.once = cover(block, rules);
    return out;
}

// The points that are measured are not those that were fitted.
TEST(BlendRefit, FewerLeavesAreNearerToTheTruth) {
    const PointBlock block = block_of(sampled("torus", 20000)),
                     truth = block_of(sampled("torus", 3000, 2));
    for (const int degree : {2, 3}) {
        const Pair p = covers_of(block, 0.02, degree);
        EXPECT_EQ(p.once.counts.leaves, p.twice.counts.leaves + p.twice.counts.needless);
        EXPECT_GT(p.twice.counts.refitted, p.twice.counts.leaves / 2);
        EXPECT_LT(rms_off(truth, leaves_of(p.twice)), 0.95 * rms_off(truth, leaves_of(p.once)))
            << degree;
    }
}

TEST(BlendRefit, OnlyPolynomialsAndErrorsChange) {
    const Pair p = covers_of(block_of(sampled("torus", 10000)), 0.02);
    auto a = leaves_of(p.once);
    const auto b = leaves_of(p.twice);
    std::set<std::uint64_t> left;  // none of them is needless
    for (const FittedSurfel& s : b) left.insert(s.point_id);
    std::erase_if(a, [&](const FittedSurfel& s) { return !left.contains(s.point_id); });
    ASSERT_EQ(a.size(), b.size());
    std::size_t moved = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        moved += a[i].surfel.polynomial.a != b[i].surfel.polynomial.a;
        FittedSurfel other = b[i];
        // the first fit was the nearest to its own points
        EXPECT_GE(other.fit_error, a[i].fit_error);
        other.surfel.polynomial = a[i].surfel.polynomial, other.fit_error = a[i].fit_error;
        EXPECT_TRUE(same(a[i], other)) << i;
    }
    // some only the second time
    EXPECT_GE(moved, p.twice.counts.refitted);
    EXPECT_LT(moved, 1.1 * static_cast<double>(p.twice.counts.refitted));
}

TEST(BlendRefit, IsTheSameForAnyNumberOfThreads) {
    const PointBlock block = block_of(sampled("sculpture", 10000));
    CoverRules rules = rules_for(block, 0.01);
    rules.refits = true;
    const auto with = [&](int n) {
        const ThreadLimit limit(n);
        return cover(block, rules);
    };
    expect_same(with(1), with(2));
}

/// Points of a plane that lies so high above a leaf on z = 0.
struct OneLeaf {
    PointBlock block;
    PointTree tree;
    FittedSurfel leaf;
    std::vector<FittedSurfel*> alone{&leaf};

    OneLeaf(double height, int degree)
        : block(along_curve(graph_points(400, 1, 3, [=](double, double) { return height; }))),
          tree(upright()) {
        leaf.surfel = {{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, degree};
    }

private:
    PointTree upright() {
        for (Vec3f& n : block.normal) n = {0, 0, 1};
        return tree_of(block);
    }
};

// Points of two planes off a leaf alike by d: the blend tells d, and all of it is believed.
TEST(BlendRefit, WhatAllPointsSayIsTakenOver) {
    OneLeaf one(0.01, 1);
    one.leaf.flags = kLeaf;
    const std::vector<BlendResidual> residuals(one.block.size(), BlendResidual{0.5f, 0.005f});
    EXPECT_EQ(refit_to_blend(one.tree, residuals, one.alone), 1u);
    EXPECT_NEAR(one.leaf.surfel.polynomial.a[0], 0.01, 1e-6);
    EXPECT_NEAR(one.leaf.surfel.polynomial.a[1], 0, 1e-6);
}

// What a leaf moves by is off the residuals then: nothing is left over to a next fit.
TEST(BlendRefit, ResidualsFollowWhatLeavesMoveBy) {
    OneLeaf one(0.01, 1);
    std::vector<BlendResidual> residuals(one.block.size());
    for (std::size_t i = 0; i < one.block.size(); ++i) {
        const auto g = static_cast<float>(weight_kernel(sq_length(one.block.position[i])));
        residuals[i] = {g, g * 0.01f};
    }
    std::vector<float> moved(one.block.size());
    EXPECT_EQ(refit_to_blend(one.tree, residuals, one.alone, moved), 1u);
    for (std::size_t i = 0; i < one.block.size(); ++i)
        EXPECT_NEAR(residuals[i].height + moved[i], 0, 1e-6) << i;
}

// Residuals without any order are chance.
TEST(BlendRefit, ChanceIsNotBelieved) {
    OneLeaf one(0, 2);
    std::vector<BlendResidual> residuals(one.block.size());
    for (std::size_t i = 0; i < residuals.size(); ++i)
        residuals[i] = {1, keyed_hash(5, one.block.id[i]) & 1 ? 0.01f : -0.01f};
    refit_to_blend(one.tree, residuals, one.alone);
    for (const double a : one.leaf.surfel.polynomial.a) EXPECT_LT(std::abs(a), 0.004);
    std::fill(residuals.begin(), residuals.end(), BlendResidual{1, 0});
    one.leaf.surfel.polynomial = {};
    EXPECT_EQ(refit_to_blend(one.tree, residuals, one.alone), 0u) << "nothing is left over";
}

}  // namespace
}  // namespace slim::test
