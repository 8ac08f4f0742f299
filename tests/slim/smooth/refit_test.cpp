#include "slim/smooth/refit.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/smooth/local_noise.h"
#include "slim/smooth/surface_projector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace slim {
namespace {

double gaussian(std::uint64_t i) {
    const double u = 1 - unit_interval(keyed_hash(1, i, 5)), v = unit_interval(keyed_hash(1, i, 6));
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
}

/// z = height(x, y) over [-1, 1]^2 with noise in z, and a model of it: 9 by 9 leaves, each the
/// tangent plane's paraboloid.
class Refit : public testing::Test {
protected:
    static constexpr double kNoise = 0.005, kLeafRadius = 0.4, kDiagonal = 2.9;
    static constexpr std::size_t kPoints = 40000;

    static double height(double x, double y) { return 0.1 * x * x - 0.15 * y * y; }

    void make(double noise, double model_off = 0, std::size_t n = kPoints) {
        for (std::size_t i = 0; i < n; ++i) {
            const double x = 2 * unit_interval(keyed_hash(1, i, 1)) - 1,
                         y = 2 * unit_interval(keyed_hash(1, i, 2)) - 1;
            block_.position.push_back({x, y, height(x, y) + noise * gaussian(i)});
            block_.id.push_back(i);
        }
        for (const Vec3d& p : block_.position) box_.extend(p);
        sort_along_curve(block_, box_);
        points_.emplace(block_, box_, 0);
        std::vector<Surfel> leaves;
        for (int i = -4; i <= 4; ++i)
            for (int j = -4; j <= 4; ++j) {
                const double x = i * 0.22, y = j * 0.22, r = kLeafRadius;
                Surfel s{{x, y, height(x, y) + model_off},
                         r,
                         Frame<double>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                         {},
                         2};
                s.polynomial.a = {0, 0.2 * x, -0.3 * y, 0.1 * r, 0, -0.15 * r};
                leaves.push_back(s);
            }
        model_.emplace(std::move(leaves));
        const double in_ball = static_cast<double>(n) / 4 * M_PI * kLeafRadius * kLeafRadius;
        noise_.assign(model_->n_leaves(), {std::hypot(noise, model_off), in_ball});
    }
    std::vector<WideRadius> radii() const {
        return wide_radii(*model_, noise_, *points_, kDiagonal);
    }
    /// Numbers of the leaves whose balls do not reach the border.
    std::vector<std::size_t> inner() const {
        std::vector<std::size_t> out;
        for (std::size_t i = 0; i < model_->n_leaves(); ++i) {
            const Vec3d& c = model_->leaf(i).center;
            if (std::max(std::abs(c.x), std::abs(c.y)) < 0.5) out.push_back(i);
        }
        return out;
    }

    PointBlock block_;
    Bbox box_;
    std::optional<PointPyramid> points_;
    std::optional<BallIndex> model_;
    std::vector<LeafNoise> noise_;
};

TEST_F(Refit, RadiiAreWideWhereASurfaceIsQuadraticAndKnowItsNoise) {
    make(kNoise);
    const auto found = radii();
    ASSERT_FALSE(inner().empty());
    double mean = 0;
    for (const std::size_t i : inner()) {
        EXPECT_TRUE(found[i].in_cloud);
        // never as narrow as rungs go: noise in the bias alone
        EXPECT_GT(found[i].radius, 0.5 * kLeafRadius);
        EXPECT_NEAR(std::sqrt(found[i].sq_noise) / kNoise, 1, 0.1);
        mean += found[i].radius / static_cast<double>(inner().size());
    }
    EXPECT_GT(mean, 0.7 * kLeafRadius);
}

TEST_F(Refit, RadiiAreTheSameForAnyNumberOfThreads) {
    make(kNoise);
    const auto many = radii();
    const ThreadLimit one(1);
    const auto few = radii();
    for (std::size_t i = 0; i < many.size(); ++i) EXPECT_EQ(many[i].radius, few[i].radius);
}

TEST_F(Refit, ALeafWhosePointsTheCloudDoesNotHoldIsKeptAndNotJudged) {
    make(kNoise);
    for (LeafNoise& n : noise_) n.n_points *= 3;
    for (const WideRadius& r : radii()) {
        EXPECT_FALSE(r.in_cloud);
        EXPECT_EQ(r.radius, 0);
    }
    const std::vector<WideRadius> found = radii();
    const RefittedSurface surface(*model_, noise_, found, *points_);
    const auto noise = local_noise(*model_, noise_, found, *points_, {});
    for (const double sq : noise) EXPECT_TRUE(std::isinf(sq));
    for (const LeafTrust& t : leaf_trust(*model_, found, noise, surface.fits(), *points_))
        EXPECT_EQ(t.share, 1);
}

TEST_F(Refit, TheFootOfAPointOutsideAllFitsIsOnTheSurfaceBeneathIt) {
    make(kNoise);
    const RefittedSurface surface(*model_, noise_, radii(), *points_);
    for (const double above : {-5.5, 0.5, 5.5}) {
        const auto foot = surface.foot({0.1, 0.2, height(0.1, 0.2) + above * kNoise}, {0, 0, 1});
        ASSERT_TRUE(foot) << above;
        EXPECT_NEAR(foot->z, height(foot->x, foot->y), kNoise / 5);
        EXPECT_LT(std::hypot(foot->x - 0.1, foot->y - 0.2), 0.01);
    }
    EXPECT_TRUE(surface.foot({0.1, 0.2, 0}, {}));  // no normal: any fit serves
    EXPECT_FALSE(surface.foot({0.1, 0.2, 0}, {0, 0, -1}));
    EXPECT_FALSE(surface.foot({0.1, 0.2, 2}, {0, 0, 1}));
}

TEST_F(Refit, APointBeyondAllBallsGoesToTheSurfaceThoughItsNormalFacesAway) {
    constexpr double kThick = 0.08;
    make(kThick);
    const RefittedSurface refitted(*model_, noise_, radii(), *points_);
    SurfaceProjector projector(SmoothSurface{*model_, &refitted, {}});
    const double above = 5.7 * kThick;
    std::vector<const Surfel*> found;
    refitted.fits().supporters({0.1, 0.2, height(0.1, 0.2) + above}, found);
    ASSERT_TRUE(found.empty());
    for (const double facing : {1.0, -1.0}) {
        const SurfacePut put =
            projector.project({0.1, 0.2, height(0.1, 0.2) + above}, {0, 0, facing});
        ASSERT_GT(sq_length(put.normal), 0) << facing;
        EXPECT_NEAR(put.point.z, height(put.point.x, put.point.y), kThick / 3);
        EXPECT_EQ(put.opposed, facing < 0);
    }
}

TEST_F(Refit, LeavesThatTakeMostFitsAreKeptWhereFitsAreFew) {
    make(kNoise);
    std::vector<WideRadius> all = radii(), few = all;
    const RefittedSurface whole(*model_, noise_, all, *points_);
    EXPECT_EQ(keep_costly_leaves(*model_, 1000000, all), 0u);
    const std::size_t kept = keep_costly_leaves(*model_, 50, few);
    EXPECT_GT(kept, 0u);
    EXPECT_LT(kept, all.size());
    std::size_t n_refitted = 0;
    for (const WideRadius& r : few) n_refitted += r.radius > 0 ? 1 : 0;
    const RefittedSurface part(*model_, noise_, few, *points_);
    EXPECT_LE(part.fits().n_leaves() - (all.size() - n_refitted), 50u);
    EXPECT_GT(whole.fits().n_leaves(), 100u);
}

TEST_F(Refit, ALeafOfFewPointsInTheNoiseOfOthersIsLeftOut) {
    make(kNoise);
    std::vector<Surfel> leaves;
    std::vector<LeafNoise> noise;
    for (std::size_t i = 0; i < model_->n_leaves(); ++i)
        leaves.push_back(model_->leaf(i)), noise.push_back(noise_[i]);
    // Two balls that a handful of points may be alone in: 5 noises up,
    // and far above what noise explains.
    for (const double above : {5 * kNoise, 20 * kNoise})
        leaves.push_back({{0.1, 0.2, height(0.1, 0.2) + above},
                          0.1,
                          Frame<double>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                          {},
                          0});
    const BallIndex model(leaves);
    std::vector<LeafNoise> of_model;
    for (std::size_t i = 0; i < model.n_leaves(); ++i)
        of_model.push_back(model.node(i) < noise.size() ? noise[model.node(i)]
                                                        : LeafNoise{kNoise, 7});
    const auto found = wide_radii(model, of_model, *points_, kDiagonal);
    const RefittedSurface surface(model, of_model, found, *points_);
    EXPECT_EQ(surface.n_strays(), 1u);
    std::size_t n_discs = 0;
    for (std::size_t i = 0; i < surface.fits().n_leaves(); ++i) {
        if (surface.fits().leaf(i).degree != 0) continue;
        ++n_discs;
        EXPECT_GT(surface.fits().leaf(i).center.z, height(0.1, 0.2) + 15 * kNoise);
    }
    EXPECT_EQ(n_discs, 1u);
}

TEST_F(Refit, NoiseIsKnownInNarrowDiscsWhereverTheModelIsOff) {
    make(1e-4, 0.002);
    std::vector<WideRadius> kept(model_->n_leaves());
    for (WideRadius& r : kept) r.in_cloud = true;
    const auto noise = local_noise(*model_, noise_, kept, *points_, {});
    const RefittedSurface surface(*model_, noise_, kept, *points_);
    const auto trust = leaf_trust(*model_, kept, noise, surface.fits(), *points_);
    for (const std::size_t i : inner()) {
        EXPECT_NEAR(std::sqrt(noise[i]) / 1e-4, 1, 0.2);
        EXPECT_NEAR(trust[i].share, std::pow(1e-4 / 0.002, 2), 0.002);
    }
}

TEST(TrustedShare, IsAllTheWayUnlessTheBiasExceedsTheNoise) {
    EXPECT_EQ(trusted_share(-1, 1), 1);
    EXPECT_EQ(trusted_share(1, 1), 1);
    EXPECT_NEAR(trusted_share(1 + 1e-9, 1), 1, 1e-6);
    EXPECT_NEAR(trusted_share(4, 1), 0.25, 1e-12);
    EXPECT_EQ(trusted_share(4, 0), 0);
    EXPECT_EQ(trusted_share(0, 0), 1);
}

}  // namespace
}  // namespace slim
