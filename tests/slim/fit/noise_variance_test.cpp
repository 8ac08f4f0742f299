#include "slim/fit/noise_variance.h"

#include "slim/base/parallel.h"
#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <vector>

namespace slim::test {
namespace {

NoiseVariance noise_of(const std::vector<Vec3d>& points, bool automatic = true) {
    return measured_noise(points, automatic ? 0 : 10);
}

/// n points of the square [-1, 1]^2, heights of standard deviation sigma.
std::vector<Vec3d> noisy_plane(std::size_t n, double sigma) {
    std::uint64_t i = 0;
    return graph_points(n, 1, 3, [&](double, double) { return sigma * gaussian(4, i++); }).position;
}

TEST(NoiseVariance, OfAPlaneWithSmallNoiseIsItsVarianceLessThePlanesFreedom) {
    // Spacing 2 / 200 = 0.01, noise a tenth of it. Covariances divide by k = 10, a plane takes 3:
    // 0.7 sigma^2, a little less for the tilt that the eigenvector finds.
    const NoiseVariance noise = noise_of(noisy_plane(40000, 1e-3));
    EXPECT_EQ(noise.neighbors, 10u);
    EXPECT_EQ(noise.n_sampled, 40000u);
    EXPECT_LT(noise.flatness, 0.1);
    EXPECT_NEAR(noise.value / 1e-6, 0.65, 0.07);
}

TEST(NoiseVariance, Row35OfAnExactPlaneIsZeroUpToRounding) {
    const NoiseVariance noise = noise_of(noisy_plane(5000, 0));
    EXPECT_LT(noise.value, 1e-30);
    EXPECT_GE(noise.value, 0);
    EXPECT_EQ(noise.n_sampled, 5000u);
}

TEST(NoiseVariance, Row07DuplicatesGiveWhatTheUniqueSetGives) {
    const std::vector<Vec3d> unique = sampled("sphere", 4000).positions;
    const NoiseVariance reference = noise_of(unique);
    for (const int copies : {2, 3, 12, 100}) {
        SCOPED_TRACE(copies);
        std::vector<Vec3d> all;
        for (int copy = 0; copy < copies; ++copy)
            all.insert(all.end(), unique.begin(), unique.end());
        // NUMERICS section 6, 7. The eigenvalues' last bits depend on the order of the neighbours.
        const NoiseVariance noise = noise_of(all);
        EXPECT_NEAR(noise.value / reference.value, 1, 1e-6);
        EXPECT_EQ(noise.n_sampled, unique.size());
        EXPECT_EQ(noise.neighbors, 10u);
    }
}

TEST(NoiseVariance, NoiseLargerThanTheSpacingTakesMoreNeighbours) {
    // Spacing 0.01, noise 0.03: ten neighbours fill a ball, not a disc.
    const std::vector<Vec3d> points = noisy_plane(40000, 0.03);
    const NoiseVariance ten = noise_of(points, false), more = noise_of(points, true);
    EXPECT_EQ(ten.neighbors, 10u);
    EXPECT_GT(ten.flatness, 0.1);
    EXPECT_LT(ten.value, 0.1 * 9e-4);  // far too small
    EXPECT_GT(more.neighbors, 10u);
    EXPECT_GT(more.value, 5 * ten.value);
    EXPECT_LT(more.value, 9e-4);
    EXPECT_LT(more.n_sampled, ten.n_sampled);
}

TEST(NoiseVariance, EdgesDoNotPassForNoise) {
    // A coarse cube, where no neighbourhood is flat, has the noise of the flattest; with as many
    // neighbours as it takes, the whole cube, it would be a tenth of its size. sigma is half a
    // spacing.
    constexpr double sigma = 0.015;
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < 6000; ++i) {
        Vec3d p{random_at(1, i), random_at(2, i), random_at(3, i)};
        p[i % 3] = i % 2 == 0 ? 1.0 : -1.0;
        for (std::size_t k = 0; k < 3; ++k) p[k] += sigma * gaussian(4 + k, i);
        points.push_back(p);
    }
    const NoiseVariance noise = noise_of(points, true);
    EXPECT_LT(noise.value, 3 * sigma * sigma);
    EXPECT_GT(noise.value, 0.3 * sigma * sigma);
}

TEST(NoiseVariance, OfTooFewDistinctPointsIsZero) {
    for (const std::size_t n : {1u, 2u, 50u}) {
        const std::vector<Vec3d> equal(n, Vec3d{1, 2, 3});
        const NoiseVariance noise = noise_of(equal);
        EXPECT_EQ(noise.value, 0);
        EXPECT_EQ(noise.n_sampled, 0u);
    }
    EXPECT_EQ(noise_of({}).value, 0);
}

/// A plane's points with other noise beyond x = `begin`.
std::vector<Vec3d> plane_with_strip(double sigma, double sigma_of_strip, double begin) {
    std::vector<Vec3d> points = noisy_plane(40000, sigma);
    for (Vec3d& p : points)
        if (p.x > begin) p.z *= sigma_of_strip / sigma;
    return points;
}

TEST(NoiseVariance, StraysDoNotCount) {
    std::vector<Vec3d> points = sampled("bumpy", 20000, 1, 1e-3).positions;
    const RobustNoise clean = robust_noise(noise_of(points));
    for (const std::size_t n : {50u, 200u, 800u}) {
        SCOPED_TRACE(n);
        std::vector<Vec3d> soiled = points;
        for (std::size_t i = 0; i < n; ++i) soiled.push_back(random_in_cube(8, i) * 3.0);
        const NoiseVariance noise = noise_of(soiled);
        EXPECT_GT(noise.value, 3 * clean.variance);
        EXPECT_NEAR(robust_noise(noise).variance, clean.variance, 0.1 * clean.variance);
    }
}

TEST(NoiseVariance, NoiseOfAPartCountsAsBendsAndEdgesWould) {
    // Spacing 0.01, noise of a hundredth of it; of 0.8 in a tenth of the points.
    const NoiseVariance noise = noise_of(plane_with_strip(1e-4, 8e-3, 0.8));
    EXPECT_EQ(noise.neighbors, 10u);
    EXPECT_GT(noise.value, 2e-6);
    EXPECT_DOUBLE_EQ(robust_noise(noise).variance, 0.005 * noise.spacing * noise.spacing);
}

TEST(NoiseVariance, APartThatIsNotFlatAsksForNoMoreNeighbours) {
    const std::vector<Vec3d> points = plane_with_strip(1e-4, 0.02, 0.2);
    EXPECT_GT(noise_of(points, false).flatness, kFlat);
    EXPECT_EQ(noise_of(points).neighbors, 10u);
}

TEST(NoiseVariance, EdgesOfACleanCubeCountAsTheyDid) {
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < 12000; ++i) {
        Vec3d p{random_at(1, i), random_at(2, i), random_at(3, i)};
        p[i % 3] = i / 3 % 2 == 0 ? 1.0 : -1.0;
        points.push_back(p);
    }
    const NoiseVariance noise = noise_of(points);
    EXPECT_LT(noise.typical, 1e-3 * noise.value);
    EXPECT_EQ(robust_noise(noise).variance, noise.value);
}

TEST(NoiseVariance, AllCountWhereNoiseIsAlike) {
    for (const auto& points :
         {noisy_plane(10000, 0), noisy_plane(10000, 1e-3), noisy_plane(10000, 0.03),
          plane_with_strip(1e-3, 3e-3, 0.8), sampled("bumpy", 20000).positions,
          sampled("torus", 5000, 1, 3e-3).positions}) {
        const NoiseVariance noise = noise_of(points);
        EXPECT_EQ(robust_noise(noise).variance, noise.value);
        EXPECT_EQ(robust_noise(noise).flatness, noise.flatness);
    }
}

TEST(NoiseVariance, ScalesAsALengthSquaredBitByBit) {
    std::vector<Vec3d> points = sampled("bumpy", 3000, 1, 1e-3).positions;
    for (std::size_t i = 0; i < 30; ++i) points.push_back(random_in_cube(8, i) * 3.0);
    const NoiseVariance one = noise_of(points);
    for (Vec3d& p : points) p *= 1024.0;
    const NoiseVariance large = noise_of(points);
    EXPECT_EQ(large.value, one.value * 1024 * 1024);
    EXPECT_EQ(large.flatness, one.flatness);
    EXPECT_EQ(robust_noise(large).variance, robust_noise(one).variance * 1024 * 1024);
    EXPECT_LT(robust_noise(one).variance, one.value);
}

TEST(NoiseVariance, IsOverFewerSamplesTheMoreNeighboursButNotFewerThanAsked) {
    const std::vector<Vec3d> points = noisy_plane(5000, 1e-3);
    const auto n_sampled = [&](std::size_t neighbors, std::size_t fewest) {
        return measured_noise(points, neighbors, 1000000, fewest).n_sampled;
    };
    EXPECT_EQ(n_sampled(10, 1), 5000u);
    EXPECT_EQ(n_sampled(100, 1), 500u);
    EXPECT_EQ(n_sampled(100, 499), 500u);
    EXPECT_EQ(n_sampled(100, 501), 501u);
    EXPECT_EQ(n_sampled(100, kFewestSamples), 1000u);
    EXPECT_EQ(n_sampled(100, 6000), 5000u);  // there are no more
    EXPECT_EQ(measured_noise(points, 100).n_sampled, kFewestSamples);
}

// The share of one slice of many: the mean is noisier, not another.
TEST(NoiseVariance, OverFewSamplesIsThatOfAllUpToTheirScatter) {
    // Thicker than the spacing, so that many neighbours are taken; their number does not depend on
    // how many samples the mean is over.
    const std::vector<Vec3d> points = noisy_plane(40000, 0.03);
    const NoiseVariance all = measured_noise(points, 0, 1000000, 40000),
                        few = measured_noise(points, 0, 1000000, 100);
    EXPECT_EQ(few.neighbors, all.neighbors);
    EXPECT_EQ(all.n_sampled, 40000u);
    EXPECT_LT(few.n_sampled, 10000u);
    EXPECT_NEAR(few.value / all.value, 1, 0.05);
    EXPECT_NEAR(few.spacing / all.spacing, 1, 0.02);
}

TEST(NoiseVariance, IsTheSameForAnyNumberOfThreads) {
    const std::vector<Vec3d> points = sampled("bumpy", 10000, 1, 1e-3).positions;
    std::vector<double> values;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        values.push_back(noise_of(points).value);
    }
    EXPECT_EQ(values[0], values[1]);
    EXPECT_EQ(values[0], values[2]);
}

}  // namespace
}  // namespace slim::test
