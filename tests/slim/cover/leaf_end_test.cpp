#include "slim/cover/leaf_end.h"

#include "slim/cover/leaf_rim.h"
#include "slim/model/surfel.h"
#include "tests/slim/cover/cover_support.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

constexpr double kRadius = 0.5;

/// The leaf of a flat ball of n points to the square [-1, 1]^2 that end at x = border.
CoveringSurfel leaf_of(std::size_t n, double border) {
    const PointBlock all = graph_points(n, 1, 3, [](double, double) { return 0.0; });
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (const Vec3d& p : all.position)
        if (p.x <= border) positions.push_back(p), normals.push_back({0, 0, 1});
    const PointBlock block = block_of(std::move(positions), std::move(normals));
    BallPoints<double> work;
    return fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, kRadius, 1, false, 1e-10, work);
}

/// How far a leaf is drawn along x.
double drawn_to(const CoveringSurfel& leaf, double share) {
    const double rho = share * kRadius;
    CoveringSurfel smaller = leaf;
    std::erase_if(smaller.covered,
                  [&](const Covered& p) { return std::hypot(p.u, p.v) > share; });
    for (Covered& p : smaller.covered)
        p.u /= static_cast<float>(share), p.v /= static_cast<float>(share);
    const Rim rim = unpack_rim(rims_of(smaller).first);
    return rho * (rim.is_whole() ? kHitTrim : rim.reach);
}

TEST(LeafEnd, ALeafIsDrawnHardlyFartherThanItsPoints) {
    constexpr std::size_t n = 40000;
    const double spacing = 2 / std::sqrt(static_cast<double>(n));
    for (const double border : {0.1, 0.17, 0.21, 0.26, 0.3, 0.34}) {
        SCOPED_TRACE(border);
        const CoveringSurfel leaf = leaf_of(n, border);
        const double share = share_at_end(leaf);
        ASSERT_GT(share, 0.6);
        EXPECT_LE(drawn_to(leaf, share) - border, 1.6 * spacing);
        EXPECT_GE(drawn_to(leaf, share), border - spacing);
    }
    // Between two reaches of rims, and beyond the last of them, the whole leaf is drawn too far.
    EXPECT_GT(drawn_to(leaf_of(n, 0.3), 1) - 0.3, 3 * spacing);
    EXPECT_LT(share_at_end(leaf_of(n, 0.3)), 1);
}

TEST(LeafEnd, WithoutAnEndOrWithFewPointsItStays) {
    EXPECT_EQ(share_at_end(leaf_of(40000, 1)), 1);
    EXPECT_EQ(share_at_end(leaf_of(40000, 0.37)), 1);  // beyond what is drawn
    EXPECT_EQ(share_at_end(leaf_of(400, 0.3)), 1);
}

/// An ellipsoid of axes 1 : 1 : c with exact normals.
PointBlock ellipsoid(std::size_t n, double c) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; positions.size() < n; ++i) {
        // Evenly over the disc, as nearly all of so flat a body is.
        const double r = std::sqrt((static_cast<double>(i) + 0.5) / static_cast<double>(n));
        const double angle = static_cast<double>(i) * 2 * std::numbers::pi * kGoldenRatio;
        const double z = (i % 2 == 0 ? c : -c) * std::sqrt(std::max(0.0, 1 - r * r));
        const Vec3d p{r * std::cos(angle), r * std::sin(angle), z};
        positions.push_back(p);
        normals.push_back(to_float(normalized(Vec3d{p.x, p.y, p.z / (c * c)})));
    }
    return block_of(std::move(positions), std::move(normals));
}

/// How far the drawn part of a leaf reaches from the axis.
double drawn_from_axis(const Surfel& s) {
    double farthest = 0;
    for (int a = 0; a < 64; ++a)
        for (int b = 1; b <= 24; ++b) {
            const double r = kHitTrim * b / 24, angle = a * std::numbers::pi / 32;
            const double u = r * std::cos(angle), v = r * std::sin(angle);
            const double w = s.polynomial.value(u, v);
            if (u * u + v * v + w * w > kHitTrim * kHitTrim || !(rim_share(s.rims, u, v) > 0))
                continue;
            const Vec3d x = s.center + s.frame.world_from_local({u, v, w}) * s.support_radius;
            farthest = std::max(farthest, std::hypot(x.x, x.y));
        }
    return farthest;
}

TEST(LevelCover, RimsOfThinThingsEndWithTheirPoints) {
    const PointBlock block = ellipsoid(40000, 0.03);
    const CoverRules rules = rules_for(block, 0.01);
    const Cover c = cover(block, rules);
    double beyond = 0;
    for (const FittedSurfel& f : leaves_of(c))
        beyond = std::max(beyond, drawn_from_axis(f.surfel) - 1);
    const double spacing = std::sqrt(2 * std::numbers::pi / 40000);
    EXPECT_LT(beyond, 1.6 * spacing);
    EXPECT_LT(c.counts.leaves, 1500u);  // not by giving the large leaves up
}

}  // namespace
}  // namespace slim::test
