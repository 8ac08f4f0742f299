#include "slim/cover/surfel_fit.h"

#include "slim/model/surfel_tree.h"
#include "slim/model/weight_kernel.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace slim::test {
namespace {

TEST(SurfelFit, StandsInTheFrameThatTheFileKeeps) {
    const PointBlock block = block_of(sampled("torus", 20000));
    const PointTree tree = tree_of(block);
    BallPoints<double> work;
    for (std::size_t i = 0; i < block.size(); i += 1000) {
        const CoveringSurfel s = fit_surfel(tree, block.position[i], to_double(block.normal[i]),
                                            0.15, 2, false, 1e-10, work);
        const Surfel& surfel = s.fitted.surfel;
        EXPECT_EQ(surfel.center, block.position[i]);
        EXPECT_EQ(surfel.frame.normal, round_normal(surfel.frame.normal));
        EXPECT_EQ(surfel.degree, 2);
        EXPECT_TRUE(s.explains_center);
        // The surface passes its centre at a distance of the order of the error.
        EXPECT_LT(std::abs(surfel.polynomial.a[0]) * 0.15, 4 * s.fitted.fit_error + 1e-6);
        EXPECT_GT(dot(surfel.frame.normal, to_double(block.normal[i])), 0.995);
    }
}

TEST(SurfelFit, CoversWhatItExplainsOnItsSide) {
    // A plane, a point above it, and a point on it that faces down.
    PointBlock block = graph_points(2000, 1, 3, [](double, double) { return 0.0; });
    block.position[0] = {0, 0, 0};
    block.position[1] = {0.1, 0, 0.05};
    block.position[2] = {0, 0.1, 0};
    block.normal[2] = {0, 0, -1};
    block.position[3] = {0.05, 0.05, 0.001};
    const PointTree tree = tree_of(block);
    BallPoints<double> work;
    // lambda: residuals up to 0.004 are explained whatever the error, which one point off lifts.
    const CoveringSurfel s = fit_surfel(tree, {0, 0, 0}, {0, 0, 1}, 0.3, 2, false, 1e-6, work);
    std::set<std::uint32_t> covered;
    for (const Covered& c : s.covered) {
        covered.insert(c.point);
        const double r = length(block.position[c.point]) / 0.3;
        EXPECT_LT(r, 1);
        EXPECT_NEAR(c.weight, weight_kernel(r * r), 1e-6);
        EXPECT_EQ(c.in_core, r < kTrim);
    }
    EXPECT_TRUE(covered.contains(0));
    EXPECT_FALSE(covered.contains(1));
    EXPECT_FALSE(covered.contains(2));
    EXPECT_TRUE(covered.contains(3));
    EXPECT_GT(covered.size(), 100u);
}

TEST(SurfelFit, CoveredPointsAreThoseOfTheFit) {
    const PointBlock block = block_of(sampled("bumpy", 5000, 1, 2e-3));
    const PointTree tree = tree_of(block);
    BallPoints<double> work;
    for (std::size_t i = 0; i < block.size(); i += 500) {
        const CoveringSurfel s = fit_surfel(tree, block.position[i], to_double(block.normal[i]),
                                            0.3, 2, false, 1e-6, work);
        const CoveringSurfel whole = cover_again(tree, s.fitted, 1e-6, work);
        const auto& again = whole.covered;
        EXPECT_EQ(whole.beside, s.beside);
        ASSERT_EQ(again.size(), s.covered.size());
        for (std::size_t k = 0; k < again.size(); ++k) {
            EXPECT_EQ(again[k].point, s.covered[k].point);
            EXPECT_EQ(again[k].weight, s.covered[k].weight);
            EXPECT_EQ(again[k].in_core, s.covered[k].in_core);
        }
    }
}

TEST(SurfelFit, OfWantedPointsItCoversThoseThatItCoversOfAll) {
    const PointBlock block = block_of(sampled("bumpy", 5000, 1, 2e-3));
    const PointTree tree = tree_of(block);
    BallPoints<double> work;
    const auto is_wanted = [](std::uint32_t point) { return point % 3 != 0; };
    const WantedOfBucket wanted = [&](std::size_t first) {
        std::uint64_t bits = 0;
        for (std::size_t k = 0; k < PointTree::kBucket && first + k < tree.size(); ++k)
            bits |= std::uint64_t{is_wanted(tree.source(first + k))} << k;
        return first == 160 ? 0 : bits;
    };
    std::size_t n_left_out = 0;
    for (std::size_t i = 0; i < block.size(); i += 100) {
        const FittedSurfel s = fit_surfel(tree, block.position[i], to_double(block.normal[i]), 0.3,
                                          2, false, 1e-6, work)
                                   .fitted;
        const CoveringSurfel some = cover_again(tree, s, 1e-6, work, wanted);
        CoveringSurfel all = cover_again(tree, s, 1e-6, work);
        std::set<std::uint32_t> left_out;
        for (std::size_t k = 160; k < 160 + PointTree::kBucket; ++k)
            left_out.insert(tree.source(k));
        n_left_out += std::erase_if(all.covered, [&](const Covered& p) {
            return !is_wanted(p.point) || left_out.contains(p.point);
        });
        ASSERT_EQ(some.covered.size(), all.covered.size());
        for (std::size_t k = 0; k < some.covered.size(); ++k) {
            EXPECT_EQ(some.covered[k].point, all.covered[k].point);
            EXPECT_EQ(some.covered[k].weight, all.covered[k].weight);
            EXPECT_EQ(some.covered[k].in_core, all.covered[k].in_core);
        }
    }
    EXPECT_GT(n_left_out, 1000u);
}

TEST(SurfelFit, AForcedLeafTakesTheLowestDegreeThatTheNoiseAsksFor) {
    const auto degree = [](double bend, double noise_variance) {
        const PointBlock block =
            graph_points(200, 1, 3, [=](double u, double) { return bend * u * u; });
        BallPoints<double> work;
        return fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.5, 2, true, noise_variance, work)
            .fitted.surfel.degree;
    };
    EXPECT_EQ(degree(0.3, 1e-2), 1);  // the bend drowns in a noise of 0.1
    EXPECT_EQ(degree(0.3, 1e-6), 2);
}

TEST(SurfelFit, LeansOverAtABorder) {
    const PointBlock whole = graph_points(4000, 1, 3, [](double, double) { return 0.0; });
    PointBlock half = whole;
    for (Vec3d& p : half.position) p.x = std::abs(p.x);
    BallPoints<double> work;
    const auto lean = [&](const PointBlock& block) {
        return fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.5, 2, false, 1e-10, work).lean;
    };
    EXPECT_LT(length(lean(whole)), 0.05);
    EXPECT_NEAR(lean(half).x, 0.2, 0.03);  // half the plane under exp(-8 x^2): 1 / sqrt(8 pi)
    EXPECT_LT(std::abs(lean(half).y), 0.05);
}

TEST(SurfelFit, TheFarFaceOfAnAcuteEdgeSaysWhereALeafEnds) {
    // Two half planes that meet at 60 degrees in the line x = -0.2, z = 0, solid between them.
    const Vec3d far_normal{-std::sin(2 * M_PI / 3), 0, std::cos(2 * M_PI / 3)};
    PointBlock block = graph_points(4000, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < block.size(); ++i) {
        Vec3d& p = block.position[i];
        if (p.x > -0.2) continue;  // beyond the edge: turned down to the other face
        const double along = -0.2 - p.x;
        p = {-0.2 + along * std::cos(M_PI / 3), p.y, -along * std::sin(M_PI / 3)};
        block.normal[i] = to_float(far_normal);
    }
    const PointTree tree = tree_of(block);
    BallPoints<double> work;
    const auto signs = [&](Edges edges) {
        return fit_surfel(tree, {0, 0, 0}, {0, 0, 1}, 0.4, 2, false, 1e-10, work, edges).edges;
    };
    EXPECT_TRUE(signs(Edges::doubtful).empty());
    const auto found = signs(Edges::real);
    ASSERT_GT(found.size(), 20u);
    for (const EdgeSign& e : found) EXPECT_NEAR(static_cast<double>(e.reach), 0.5, 1e-3);
}

TEST(SurfelFit, TheOtherSideOfASheetIsNoEdge) {
    PointBlock block = graph_points(4000, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < block.size(); i += 2) {
        block.position[i].z = -0.05;
        block.normal[i] = {0, 0, -1};
    }
    BallPoints<double> work;
    EXPECT_TRUE(fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.4, 2, false, 1e-10, work,
                           Edges::real)
                    .edges.empty());
}

TEST(SurfelFit, ReportsNormalsThatDisagree) {
    PointBlock block = graph_points(500, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < block.size(); ++i) {
        const double angle = 2.399963 * static_cast<double>(i);
        block.normal[i] = to_float(normalized(Vec3d{std::cos(angle), std::sin(angle), 0.05}));
    }
    BallPoints<double> work;
    const CoveringSurfel s =
        fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.5, 2, false, 1e-10, work);
    EXPECT_TRUE(s.normals_disagree);
    EXPECT_NEAR(s.fitted.surfel.frame.normal.z, 1, 1e-6);
}

TEST(SurfelFit, AFewPointsKeepTheirDegreeUnlessAnEdgeIsAmongThem) {
    // 13 points in the ball: twice a quadratic's coefficients, but less freedom than it wants.
    PointBlock block;
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y) {
            block.position.push_back({0.1 * x, 0.1 * y, 0.05 * 0.01 * x * x});
            block.normal.push_back(to_float(normalized(Vec3d{-0.01 * x, 0, 1})));
            block.id.push_back(block.id.size());
        }
    BallPoints<double> work;
    const auto degree = [&](Edges edges) {
        const auto leaf =
            fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.21, 2, false, 1e-12, work, edges);
        EXPECT_EQ(leaf.fitted.n_points, 13u);
        return leaf.fitted.surfel.degree;
    };
    EXPECT_EQ(degree(Edges::ignored), 2);
    EXPECT_EQ(degree(Edges::doubtful), 2);
    EXPECT_EQ(degree(Edges::real), 2);
    block.normal[2] = to_float(normalized(Vec3d{-1, 0, 1}));  // at (-0.2, 0)
    EXPECT_EQ(degree(Edges::ignored), 2);
    EXPECT_EQ(degree(Edges::doubtful), 1);
    EXPECT_EQ(degree(Edges::real), 1);
}

}  // namespace
}  // namespace slim::test
