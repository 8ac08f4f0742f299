#include "slim/cover/air_places.h"

#include "slim/cover/leaf_rim.h"
#include "slim/cover/wider_balls.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

/// Points of the faces z = 0 and x = 0 of a solid that meet in the y axis, outside at 90 degrees;
/// or at 270, where the second face rises.
PointBlock edge_points(bool rises, std::size_t n = 6000) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < n; ++i) {
        const double s = random_at(6, 2 * i), y = random_at(6, 2 * i + 1);
        const double side = rises ? 1 : -1;
        positions.push_back(s < 0 ? Vec3d{0, y, -side * s} : Vec3d{-s, y, 0});
        normals.push_back(s < 0 ? Vec3f{rises ? -1.0f : 1.0f, 0, 0} : Vec3f{0, 0, 1});
    }
    return block_of(std::move(positions), std::move(normals));
}

/// The plane z = 0 about a place, its ball's points in `ball`.
Surfel level_disc(const PointBlock& block, const Vec3d& center, double radius,
                  BallPoints<double>& ball) {
    gather_ball(tree_of(block), center, radius, ball);
    return {center, radius, frame_from_normal(Vec3d{0, 0, 1}), {}, 1};
}

/// World x of a place.
double x_of(const Surfel& s, const AirPlace& p) {
    return s.center.x +
           s.support_radius *
               s.frame.world_from_local({static_cast<double>(p.u), static_cast<double>(p.v), 0}).x;
}

TEST(AirPlaces, ThereAreHardlyAnyOnASurface) {
    const PointBlock block = edge_points(false);
    BallPoints<double> ball;
    std::size_t n = 0;
    for (double y = -0.8; y < 0.81; y += 0.2) {
        const Surfel s = level_disc(block, {-0.5, y, 0}, 0.15, ball);
        n += air_places(s, ball).size();
    }
    EXPECT_LT(n, 9 * 201 / 100) << "holes among random points";
}

TEST(AirPlaces, TheyLieBeyondAnEdgeThatFallsAway) {
    const PointBlock block = edge_points(false);
    BallPoints<double> ball;
    const Surfel s = level_disc(block, {-0.03, 0, 0}, 0.15, ball);
    const auto air = air_places(s, ball);
    ASSERT_GT(air.size(), 20u);
    // Right before the edge the nearest point may be the other face's:
    // that is no more than a spacing, 0.026.
    for (const AirPlace& p : air) EXPECT_GT(x_of(s, p), -0.026);
    const auto reach = [&](const AirPlace& p) { return x_of(s, p); };
    EXPECT_GT(reach(*std::max_element(
                  air.begin(), air.end(),
                  [&](const AirPlace& a, const AirPlace& b) { return reach(a) < reach(b); })),
              0.05);  // the core ends at 0.07
    EXPECT_TRUE(std::all_of(air.begin(), air.end(),
                            [&](const AirPlace& p) { return p.far || reach(p) < 0.03; }));
}

/// By all points of the ball, one after the other; sorted.
std::vector<std::array<double, 3>> by_all_points(const Surfel& s, const BallPoints<double>& ball) {
    std::vector<std::array<double, 3>> out;
    const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(ball.n));
    for (int i = 0; i < 208; ++i) {
        const double r = kTrim * std::sqrt((i + 0.5) / 208);
        const double angle = i * 2 * std::numbers::pi * kGoldenRatio;
        const double u = r * std::cos(angle), v = r * std::sin(angle);
        const Vec3d foot = s.frame.world_from_local({u, v, s.polynomial.value(u, v)});
        if (sq_length(foot) >= kTrim * kTrim) continue;
        std::size_t nearest = 0;
        for (std::size_t p = 1; p < ball.n; ++p)
            if (sq_length(foot - ball.place(p)) < sq_length(foot - ball.place(nearest)))
                nearest = p;
        const Vec3d away = foot - ball.place(nearest);
        const double height = dot(ball.normal(nearest), away);
        const bool far = length(away) > 1.5 * spacing || std::abs(height) > 0.3 * spacing;
        if (far || height > 0.15 * spacing) out.push_back({u, v, far ? 1.0 : 0.0});
    }
    std::sort(out.begin(), out.end());
    return out;
}

TEST(AirPlaces, AreThoseThatAllPointsOfTheBallTell) {
    const PointBlock block = edge_points(false);
    BallPoints<double> ball;
    std::size_t n_found = 0;
    for (const double x : {-0.08, -0.05, -0.03, 0.0})
        for (const double radius : {0.06, 0.1, 0.15, 0.4}) {  // of 15 to 700 points
            SCOPED_TRACE(testing::Message() << x << " " << radius);
            const Surfel s = level_disc(block, {x, 0, 0}, radius, ball);
            std::vector<std::array<double, 3>> found;
            for (const AirPlace& p : air_places(s, ball))
                found.push_back({static_cast<double>(p.u), static_cast<double>(p.v),
                                 p.far ? 1.0 : 0.0});
            std::sort(found.begin(), found.end());
            const auto expected = by_all_points(s, ball);
            ASSERT_EQ(found.size(), expected.size());
            n_found += found.size();
            for (std::size_t i = 0; i < found.size(); ++i)
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[i][k], expected[i][k], 1e-6);
        }
    EXPECT_GT(n_found, 100u);
}

TEST(AirPlaces, AHoleIsFar) {
    PointBlock block = edge_points(false), rest;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (std::hypot(block.position[i].x + 0.42, block.position[i].y) < 0.06) continue;
        rest.position.push_back(block.position[i]);
        rest.normal.push_back(block.normal[i]);
        rest.id.push_back(i);
    }
    BallPoints<double> ball;
    const Surfel s = level_disc(rest, {-0.5, 0, 0}, 0.15, ball);
    const auto air = air_places(s, ball);
    ASSERT_FALSE(air.empty());
    for (const AirPlace& p : air) {
        EXPECT_TRUE(p.far);
        EXPECT_NEAR(x_of(s, p), -0.42, 0.06);
    }
}

TEST(AirPlaces, ARimEndsTheLeafBeforeThem) {
    const PointBlock block = edge_points(false);
    const PointTree tree = tree_of(block);
    BallPoints<double> ball;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < tree.size(); ++i) {
        const Vec3d c = tree.position(i);
        if (c.z != 0 || c.x > -0.02 || c.x < -0.06 || std::abs(c.y) > 0.7) continue;
        CoveringSurfel leaf = fit_surfel(tree, c, {0, 0, 1}, 0.15, 1, false, 1e-10, ball);
        leaf.air = air_places(leaf.fitted.surfel, ball);
        ASSERT_FALSE(leaf.air.empty());
        const PackedRims rims = rims_of(leaf);
        for (const AirPlace& p : leaf.air) {
            if (x_of(leaf.fitted.surfel, p) < 0.03) continue;
            EXPECT_EQ(rim_share(rims, static_cast<double>(p.u), static_cast<double>(p.v)), 0);
        }
        for (const Covered& p : leaf.covered)
            for (const PackedRim packed : {rims.first, rims.second}) {
                const Rim rim = unpack_rim(packed);
                EXPECT_LE(rim.u * static_cast<double>(p.u) + rim.v * static_cast<double>(p.v),
                          rim.reach + 1e-6);
            }
        ++seen;
    }
    EXPECT_GT(seen, 20u);
}

TEST(WiderBalls, RadiiFallFromTheWantedPointsToThoseThere) {
    const PointBlock block = edge_points(false);
    const PointTree tree = tree_of(block);
    BallPoints<double> work;
    const Vec3d c = tree.position(7);
    const auto radii = wider_radii(tree, c, 0.07, 2, 144, work);
    ASSERT_EQ(radii.size(), 4u);
    EXPECT_TRUE(std::is_sorted(radii.rbegin(), radii.rend()));
    EXPECT_GT(radii.back(), 0.07f);
    EXPECT_EQ(count_in_ball(tree, c, static_cast<double>(radii.front()) * (1 + 1e-6), 1000), 145u);
    EXPECT_TRUE(wider_radii(tree, c, 0.5, 2, 144, work).empty()) << "there are as many already";
    for (const float r : wider_radii(tree, c, 0.07, 0.08, 144, work)) EXPECT_LE(r, 0.08f);
}

TEST(WiderBalls, ABallGatheredForAllHoldsThoseOfEachRadius) {
    const PointBlock block = edge_points(false);
    const PointTree tree = tree_of(block);
    BallPoints<double> all, shrunk, fresh;
    const Vec3d c = tree.position(7);
    for (const float r : wider_radii(tree, c, 0.07, 2, 144, all)) {
        const auto radius = static_cast<double>(r);
        shrink_ball(all, radius, shrunk);
        gather_ball(tree, c, radius, fresh);
        ASSERT_EQ(shrunk.n, fresh.n);
        EXPECT_EQ(shrunk.radius, radius);
        for (std::size_t i = 0; i < fresh.n; ++i) {
            ASSERT_EQ(shrunk.index[i], fresh.index[i]);
            ASSERT_NEAR(shrunk.x[i], fresh.x[i], 1e-12);
            ASSERT_EQ(shrunk.nz[i], fresh.nz[i]);
        }
    }
}

TEST(WiderBalls, APoorFitIsNotWide) {
    const PointBlock block =
        graph_points(4000, 1, 3, [](double x, double y) { return 0.3 * std::sin(9 * x) + 0 * y; });
    BallPoints<double> ball;
    const CoveringSurfel leaf =
        fit_surfel(tree_of(block), block.position[3], {0, 0, 1}, 0.4, 1, false, 1e-10, ball);
    EXPECT_GT(leaf.fitted.fit_error, 0.06 * 0.4);
    EXPECT_FALSE(is_well_fitted(leaf));
}

}  // namespace
}  // namespace slim::test
