#pragma once

#include "slim/cover/level_cover.h"
#include "slim/model/surfel_tree.h"
#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <vector>

namespace slim::test {

inline CoverRules rules_for(const PointBlock& block, double mdl_threshold = 0.02, int degree = 2) {
    CoverRules rules;
    rules.degree = degree;
    rules.mdl_threshold = mdl_threshold;
    rules.diagonal = box_of(block).diagonal();
    rules.least_radius = rules.diagonal * 1e-15;
    const double measured = measured_noise(block.position, 0, 10000).value;
    const double quantum = rules.diagonal * 2.2e-16;
    rules.noise_variance = std::max(measured, 16 * quantum * quantum);
    return rules;
}

inline Cover cover(const PointBlock& block, const CoverRules& rules) {
    Reporter silent;
    return cover_points(block, rules, silent);
}

inline std::vector<FittedSurfel> leaves_of(const Cover& c) {
    std::vector<FittedSurfel> out;
    std::copy_if(c.surfels.begin(), c.surfels.end(), std::back_inserter(out),
                 [](const FittedSurfel& s) { return (s.flags & kLeaf) != 0; });
    return out;
}

inline bool same(const FittedSurfel& a, const FittedSurfel& b) {
    return a.surfel.center == b.surfel.center &&
           a.surfel.support_radius == b.surfel.support_radius &&
           a.surfel.frame.normal == b.surfel.frame.normal &&
           a.surfel.frame.u_axis == b.surfel.frame.u_axis &&
           a.surfel.polynomial.a == b.surfel.polynomial.a && a.surfel.degree == b.surfel.degree &&
           a.fit_error == b.fit_error && a.n_points == b.n_points && a.level == b.level &&
           a.flags == b.flags && a.point_id == b.point_id;
}

inline void expect_same(const Cover& a, const Cover& b) {
    ASSERT_EQ(a.surfels.size(), b.surfels.size());
    for (std::size_t i = 0; i < a.surfels.size(); ++i)
        ASSERT_TRUE(same(a.surfels[i], b.surfels[i])) << i;
    EXPECT_EQ(a.counts.leaves, b.counts.leaves);
    EXPECT_EQ(a.counts.evaluated, b.counts.evaluated);
    EXPECT_EQ(a.counts.point_visits, b.counts.point_visits);
}

/// Points that are neither covered by the leaves nor the centre of one.
// without refits
inline std::size_t uncovered(const PointBlock& block, const Cover& c, double noise_variance) {
    const PointTree tree = tree_of(block);
    std::vector<double> weight(block.size(), 0);
    std::vector<bool> core(block.size(), false);
    std::set<std::uint64_t> centers;
    BallPoints<double> work;
    for (const FittedSurfel& s : leaves_of(c)) {
        centers.insert(s.point_id);
        const float times = s.flags & (kForced | kLimited) ? kLimitedTimes : 1;
        for (const Covered& p : cover_again(tree, s, noise_variance, work).covered) {
            weight[p.point] += times * p.weight;
            if (p.in_core) core[p.point] = true;
        }
    }
    std::size_t n = 0;
    for (std::size_t i = 0; i < block.size(); ++i)
        n += !(core[i] && weight[i] >= kCoverage - 1e-6) && !centers.contains(block.id[i]);
    return n;
}

inline double median_radius(const std::vector<FittedSurfel>& leaves) {
    std::vector<double> radii;
    for (const FittedSurfel& s : leaves) radii.push_back(s.surfel.support_radius);
    std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2),
                     radii.end());
    return radii[radii.size() / 2];
}

}  // namespace slim::test
