// Fits that follow the points' normals (slim/fit/notes/0007).
#include "slim/fit/local_fit.h"
#include "slim/fit/moments.h"
#include "slim/fit/nested_cholesky.h"
#include "slim/fit/normal_variance.h"
#include "slim/fit/radius_ladder.h"
#include "slim/normals/covariance.h"
#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace slim::test {
namespace {

const Frame<double> kUpright = frame_from_normal(Vec3d{0, 0, 1});
constexpr double kNoise = 0.02;

/// A cubic with noisy heights over the disc of radius 1; normals are those of the cubic,
/// tilted along u.
BallPoints<double> noisy_cubic(const Polynomial<double>& truth, std::uint64_t seed, double noise,
                               double tilt = 0) {
    std::uint64_t i = 0;
    PointBlock block = graph_points(1500, 1, seed, [&](double u, double v) {
        return truth.value(u, v) + noise * gaussian(seed + 50, i++);
    });
    for (std::size_t k = 0; k < block.size(); ++k) {
        const Vec3d p = block.position[k];
        block.normal[k] =
            to_float(normalized(Vec3d{-truth.d_u(p.x, p.y) + tilt, -truth.d_v(p.x, p.y), 1}));
    }
    BallPoints<double> ball;
    gather_ball(tree_of(block), {0, 0, 0}, 1, ball);
    return ball;
}

Polynomial<double> a_cubic() {
    Polynomial<double> p;
    for (std::size_t k = 1; k < kMaxCoefficients; ++k) p.a[k] = 0.1 * random_at(7, k);
    return p;
}

double off_slopes(const LocalFit& fit, const Polynomial<double>& truth) {
    double sum = 0;
    for (std::size_t k = 1; k < kMaxCoefficients; ++k)
        sum += std::pow(fit.polynomial.a[k] - truth.a[k], 2);
    return std::sqrt(sum);
}

TEST(NormalsInFit, BetterThanThePointsTheyMakeTheShapeBetter) {
    const Polynomial<double> truth = a_cubic();
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        auto ball = noisy_cubic(truth, seed, kNoise);
        const LocalFit alone = fit_ball(ball, 1, kUpright, 3);
        ball.normals_count = true;
        for (const double shrink : {1.0, 0.8}) {
            const LocalFit both = fit_ball(ball, shrink, kUpright, 3);
            Polynomial<double> scaled;
            std::size_t k = 0;
            for (int d = 0; d <= 3; ++d)
                for (int t = 0; t <= d; ++t, ++k)
                    scaled.a[k] = truth.a[k] * std::pow(shrink, d - 1);
            EXPECT_LT(off_slopes(both, scaled), 0.02 * off_slopes(alone, truth));
            EXPECT_NEAR(both.polynomial.a[0], 0, 4 * kNoise / std::sqrt(both.n_effective));
            EXPECT_NEAR(std::sqrt(both.sq_error) / kNoise, 1, 0.1);
        }
    }
}

TEST(NormalsInFit, NormalsThatThePointsContradictAreNotFollowed) {
    const Polynomial<double> truth = a_cubic();
    for (const double tilt : {0.04, 0.1}) {  // heights tell slopes to 0.003 here
        auto ball = noisy_cubic(truth, 1, kNoise, tilt);
        const LocalFit alone = fit_ball(ball, 1, kUpright, 3);
        ball.normals_count = true;
        EXPECT_EQ(fit_ball(ball, 1, kUpright, 3).polynomial.a, alone.polynomial.a) << tilt;
    }
}

TEST(NormalsInFit, AnExactFieldStaysExact) {
    const Polynomial<double> truth = a_cubic();
    auto ball = noisy_cubic(truth, 2, 0);
    ball.normals_count = true;
    const LocalFit fit = fit_ball(ball, 1, kUpright, 3);
    EXPECT_LT(off_slopes(fit, truth), 1e-6);  // normals are floats
}

TEST(NormalsInFit, ABallWithoutNormalsIsFittedToItsPoints) {
    auto ball = noisy_cubic(a_cubic(), 3, kNoise);
    std::fill(ball.nx.begin(), ball.nx.end(), 0.0f);
    std::fill(ball.ny.begin(), ball.ny.end(), 0.0f);
    std::fill(ball.nz.begin(), ball.nz.end(), 0.0f);
    const LocalFit alone = fit_ball(ball, 1, kUpright, 3);
    ball.normals_count = true;
    EXPECT_EQ(fit_ball(ball, 1, kUpright, 3).polynomial.a, alone.polynomial.a);
}

TEST(NormalsInFit, GainSeenByItselfIsTheGain) {
    const auto ball = noisy_cubic(a_cubic(), 4, kNoise);
    const auto m = accumulate_moments<4>(ball, kUpright, 1);
    const NestedCholesky solver(4, m.monomial, m.height, m.sq_height);
    for (int degree = 1; degree <= 4; ++degree) {
        const auto there = solver.gain_in(solver, degree);
        EXPECT_NEAR(there.sq_gain / solver.sq_gain(degree), 1, 1e-9);
        EXPECT_NEAR(there.n_errors, degree + 1, 1e-9);
    }
}

/// The ladder of a shape's points with 0.1 % of noise, at T_MDL 0.01.
struct NoisyShape {
    PointBlock points;
    double l;
    PointPyramid pyramid;
    RadiusLadder ladder;

    NoisyShape(const char* name, std::size_t n, int degree)
        : points(block_of(sampled(name, n, 1, 1e-3))),
          l(box_of(points).diagonal()),
          pyramid(points, box_of(points), 1),
          ladder(pyramid, {1e-6 * l * l, 0.01 * l}, l / 10, 1e-9, degree, {}) {}
};

TEST(NormalsInFit, TheLadderFindsASmallerBallWhereNormalsShowWhatNoiseHides) {
    const NoisyShape shape("bumpy", 50000, 3);
    const PointBlock& points = shape.points;
    const RadiusLadder& ladder = shape.ladder;
    LadderWork alone, both;
    both.ball.normals_count = true;
    double sum = 0;
    constexpr std::uint64_t n = 40;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Vec3d p = points.position[997 * i], normal = to_double(points.normal[997 * i]);
        const double wide = ladder.choose(p, normal, 0, alone).radius;
        sum += ladder.choose(p, normal, 0, both).radius / wide / n;
    }
    EXPECT_LT(sum, 0.8);
    EXPECT_GT(sum, 0.3);
}

TEST(NormalsInFit, TheLadderStopsWhereSlopesTurnThoughTheNextDegreeFindsNothing) {
    const NoisyShape shape("torus", 100000, 2);
    const PointBlock& points = shape.points;
    const RadiusLadder& ladder = shape.ladder;
    LadderWork work;
    work.ball.normals_count = true;
    int n = 0;
    for (std::size_t i = 0; i < points.size() && n < 40; ++i) {
        const Vec3d p = points.position[i];
        // the inner equator, where third derivatives vanish
        if (std::abs(p.z) > 0.02 || std::hypot(p.x, p.y) > 0.8) continue;
        EXPECT_LT(ladder.choose(p, to_double(points.normal[i]), 0, work).radius, 0.26);
        ++n;
    }
    EXPECT_EQ(n, 40);
}

/// normal_variance_of all points of a noisy plane's neighbourhood.
double variance_of(double curvature, double noise) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const double u = random_at(1, i), v = random_at(2, i);
        positions.push_back({u, v, 0});
        normals.push_back(
            to_float(Vec3d{curvature * u + noise * gaussian(3, i), noise * gaussian(4, i), 1}));
    }
    std::vector<std::uint32_t> all(positions.size());
    std::iota(all.begin(), all.end(), 0u);
    return normal_variance_of(positions, normals, all, {0, 0, 1});
}

TEST(NormalVariance, IsOfTheNoiseNotOfTheCurvature) {
    EXPECT_NEAR(std::sqrt(variance_of(0, 0.1)), 0.1, 0.005);
    EXPECT_NEAR(std::sqrt(variance_of(0.3, 0.01)), 0.01, 0.0005);
    EXPECT_LT(std::sqrt(variance_of(0.3, 0)), 1e-6);
    EXPECT_GT(variance_of(0, 0), 0);
}

TEST(NormalVariance, NormalsInformWhereTheyAreBetterThanNoisyPoints) {
    constexpr double h = 0.01;
    EXPECT_TRUE(normals_inform(0.09 * h * h, 2e-5, h));    // noise 0.3 spacings, 0.25 degrees
    EXPECT_FALSE(normals_inform(0.09 * h * h, 1e-3, h));   // 2 degrees: as good as some scans' own
    EXPECT_FALSE(normals_inform(1e-4 * h * h, 1e-14, h));  // hardly any noise
    EXPECT_FALSE(normals_inform(0, 0, 0));
}

/// normal_independence of a noisy sphere's normals: exact ones,
/// or those of planes through so many neighbours.
double independence(std::size_t estimated_from, std::size_t first_k) {
    PointBlock points = along_curve(block_of(sampled("sphere", 40000, 1, 1e-3)));
    const NearestSearch search(points.position);
    std::vector<std::uint32_t> all(points.size()), samples;
    std::iota(all.begin(), all.end(), 0u);
    for (std::uint32_t i = 0; i < points.size(); i += 67) samples.push_back(i);
    const std::vector<Vec3f> exact = points.normal;
    if (estimated_from > 0)
        search.for_each(
            all, estimated_from, [&](std::size_t w, std::span<const std::uint32_t> near) {
                const Vec3d n = spread_of(points.position, near).normal;
                points.normal[w] = to_float(n * std::copysign(1.0, dot(n, to_double(exact[w]))));
            });
    return normal_independence(search, samples, points.normal, first_k);
}

TEST(NormalVariance, EstimatesAreToldFromIndependentNormals) {
    EXPECT_GT(independence(0, 10), 1.1 * kIndependent);
    for (const std::size_t k : {16u, 24u, 33u, 47u, 100u, 180u})
        EXPECT_LT(independence(k, 10), 0.9 * kIndependent) << k;
}

}  // namespace
}  // namespace slim::test
