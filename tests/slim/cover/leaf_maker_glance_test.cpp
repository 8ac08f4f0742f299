#include "slim/cover/leaf_maker.h"

#include "slim/cover/level_cover.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slim::test {
namespace {

constexpr std::size_t kPoints = 120000;
constexpr double kSigma = 0.023;  // four spacings

/// A square of side 2 in thick noise; point 0 lies at a height over its middle.
PointBlock noisy_square(double height) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(0, kSigma);
    PointBlock block = graph_points(kPoints, 1, 3, [&](double, double) { return noise(random); });
    block.position[0] = {0, 0, height};
    block.normal[0] = {0, 0, 1};
    return block;
}

/// What becomes of a sparse leaf of a radius about point 0, where leaves below `lower` wait.
LeafCandidate made(const PointBlock& block, double radius, double lower) {
    CoverRules rules;
    rules.diagonal = box_of(block).diagonal();
    rules.noise_variance = rules.typical_variance = kSigma * kSigma;
    rules.spacing = 2 / std::sqrt(kPoints);
    const PointPyramid pyramid(block, box_of(block), 1);
    const LeafMaker maker(block, rules, pyramid);
    LeafCandidate c;
    c.leaf = c.sparse = true;
    c.choice.radius = radius;
    c.choice.degree = 2;
    LeafWork work;
    maker.make(c, lower, work);
    return c;
}

TEST(LeafMakerGlance, ACentreFarOutInNoiseIsNotFittedToAllOfItsBall) {
    const LeafCandidate c = made(noisy_square(6 * kSigma), 0.9, 0.5);
    EXPECT_TRUE(c.leaf);
    EXPECT_FALSE(c.surfel.explains_center);
    EXPECT_EQ(c.surfel.fitted.n_points, 0u);
}

TEST(LeafMakerGlance, ACentreThatIsExplainedIsFittedToAll) {
    const LeafCandidate c = made(noisy_square(2 * kSigma), 0.9, 0.5);
    EXPECT_TRUE(c.leaf);
    EXPECT_TRUE(c.surfel.explains_center);
    EXPECT_GT(c.surfel.fitted.n_points, kPoints / 2);
    EXPECT_GT(c.surfel.covered.size(), kPoints / 2);
}

TEST(LeafMakerGlance, ABallThatIsTooThickGetsSmallerOrWaits) {
    const LeafCandidate c = made(noisy_square(2 * kSigma), 0.6, 0.5);
    EXPECT_FALSE(c.leaf);
    EXPECT_NEAR(c.choice.radius, 0.6 * kGoldenRatio, 1e-6);
    EXPECT_EQ(c.surfel.fitted.n_points, 0u);
}

}  // namespace
}  // namespace slim::test
