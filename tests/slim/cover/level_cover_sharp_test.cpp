#include "slim/cover/level_cover.h"

#include "slim/base/parallel.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

/// Points on the faces of the unit cube, on a grid of `n` a side; those on edges and corners have
/// the mean normal of their faces, as a mesh's vertices.
PointBlock cube_points(int n) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (int x = 0; x <= n; ++x)
        for (int y = 0; y <= n; ++y)
            for (int z = 0; z <= n; ++z) {
                const int at[3] = {x, y, z};
                Vec3d normal;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    normal[axis] = at[axis] == 0 ? -1 : at[axis] == n ? 1 : 0;
                if (!(sq_length(normal) > 0)) continue;
                positions.push_back({double(x) / n, double(y) / n, double(z) / n});
                normals.push_back(to_float(normalized(normal)));
            }
    return block_of(std::move(positions), std::move(normals));
}

/// Largest distance of a place on the cube's edges, off the grid, to the joined function of a leaf
/// that holds it in its core; infinite if none does.
double worst_on_edges(const std::vector<FittedSurfel>& leaves) {
    double worst = 0;
    for (double t = 0.0071; t < 1; t += 0.0173)
        for (const Vec3d& p : {Vec3d{t, 0, 0}, Vec3d{1, t, 0}, Vec3d{0, 1, t}, Vec3d{1, 1, t}}) {
            double best = INFINITY;
            for (const FittedSurfel& f : leaves) {
                const Vec3d x = (p - f.surfel.center) / f.surfel.support_radius;
                if (sq_length(x) < kTrim * kTrim)
                    best = std::min(best, std::abs(f.surfel.value(x)) * f.surfel.support_radius);
            }
            worst = std::max(worst, best);
        }
    return worst;
}

TEST(LevelCover, ACubeWithSharpEdgesIsExactInFewerLeaves) {
    const PointBlock block = cube_points(24);
    CoverRules rules = rules_for(block, 0.01);
    const Cover smooth = cover(block, rules);
    EXPECT_EQ(smooth.counts.sharp_edges + smooth.counts.sharp_corners, 0u);
    EXPECT_EQ(smooth.counts.sharp_rungs, 0u);
    rules.sharp = true;
    const Cover sharp = cover(block, rules);
    // today 300 and 312, which round the edges off
    EXPECT_LT(sharp.counts.leaves, smooth.counts.leaves);
    EXPECT_GT(worst_on_edges(leaves_of(smooth)), 1e-3);
    EXPECT_GE(sharp.counts.sharp_corners, 8u);
    EXPECT_GE(sharp.counts.sharp_edges, 12u);
    EXPECT_EQ(sharp.counts.unexplained + sharp.counts.isolated, 0u);
    EXPECT_LT(worst_on_edges(leaves_of(sharp)), 1e-6);
    for (const FittedSurfel& leaf : leaves_of(sharp)) {
        if (leaf.surfel.n_sheets() < 2) continue;
        EXPECT_EQ(leaf.surfel.sharp->outer, Join::max) << "all edges of a cube are convex";
        EXPECT_LT(leaf.fit_error, 1e-7);
    }
}

/// RMS distance of the centres of leaves from the unit cube.
double rms_to_cube(const std::vector<FittedSurfel>& leaves) {
    double sum = 0;
    for (const FittedSurfel& f : leaves) {
        const Vec3d p = f.surfel.center - Vec3d{0.5, 0.5, 0.5};
        const double d = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 0.5;
        sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(leaves.size()));
}

TEST(LevelCover, TheFacesOfACubeInNoiseAreAgreedUpon) {
    PointBlock block = cube_points(40);
    const double noise = 0.2 / 40;
    for (std::size_t i = 0; i < block.size(); ++i) {
        Vec3d n = to_double(block.normal[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            block.position[i][k] += noise * gaussian(1, 3 * i + k);
            n[k] += 0.15 * gaussian(2, 3 * i + k);
        }
        block.normal[i] = to_float(normalized(n));
    }
    block = along_curve(std::move(block));
    CoverRules rules = rules_for(block, 0.01);
    rules.spacing = 1.0 / 40;
    rules.typical_variance = rules.noise_variance / 2;
    EXPECT_FALSE(cover(block, rules).are_on_faces) << "edges are not asked for";
    rules.sharp = true;
    const Cover agreed = cover(block, rules);
    EXPECT_TRUE(agreed.are_on_faces);
    rules.are_estimated = true;
    const Cover raw = cover(block, rules);
    EXPECT_FALSE(raw.are_on_faces);
    EXPECT_LT(rms_to_cube(leaves_of(agreed)), 0.6 * rms_to_cube(leaves_of(raw)));
    EXPECT_LE(worst_on_edges(leaves_of(agreed)), worst_on_edges(leaves_of(raw)));
    rules.are_estimated = false;
    rules.typical_variance = rules.noise_variance / 100;
    EXPECT_FALSE(cover(block, rules).are_on_faces) << "edges alone make lambda";
}

/// An octahedron on a grid; points on edges and corners have the mean normal of their faces.
PointBlock octahedron_points(int n) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const auto sign = [](int k) { return k > 0 ? 1.0 : k < 0 ? -1.0 : 0.0; };
    for (int x = -n; x <= n; ++x)
        for (int y = -n; y <= n; ++y)
            for (int z = -n; z <= n; ++z) {
                if (std::abs(x) + std::abs(y) + std::abs(z) != n) continue;
                positions.push_back({double(x) / n, double(y) / n, double(z) / n});
                normals.push_back(to_float(normalized(Vec3d{sign(x), sign(y), sign(z)})));
            }
    return block_of(std::move(positions), std::move(normals));
}

TEST(LevelCover, NoSmoothLeafRoundsOffACornerOfFourFaces) {
    // No sheets hold four faces: the leaves at the corners are smooth ones.
    const PointBlock block = octahedron_points(20);
    CoverRules rules = rules_for(block, 0.01);
    rules.sharp = true;
    const Cover c = cover(block, rules);
    EXPECT_LE(uncovered(block, c, rules.noise_variance), c.counts.unexplained + c.counts.isolated);
    for (const FittedSurfel& leaf : leaves_of(c)) {
        if (leaf.surfel.n_sheets() > 1 || leaf.n_points <= 3) continue;
        EXPECT_LE(leaf.fit_error, 0.055 * leaf.surfel.support_radius) << leaf.n_points;
    }
}

/// Vertices of an icosahedron with edges of length 2.
std::vector<Vec3d> icosahedron_vertices() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<Vec3d> out;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-g, g})
            out.insert(out.end(), {Vec3d{0, a, b}, Vec3d{a, b, 0}, Vec3d{b, 0, a}});
    return out;
}

/// Points within its faces, `n` rows each, with the faces' normals.
PointBlock icosahedron_points(int n) {
    const std::vector<Vec3d> v = icosahedron_vertices();
    const auto is_edge = [&](std::size_t a, std::size_t b) {
        return std::abs(sq_length(v[a] - v[b]) - 4) < 1e-6;
    };
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t c = 2; c < v.size(); ++c)
        for (std::size_t b = 1; b < c; ++b)
            for (std::size_t a = 0; a < b; ++a) {
                if (!is_edge(a, b) || !is_edge(b, c) || !is_edge(a, c)) continue;
                for (int i = 0; i < n; ++i)
                    for (int j = 0; i + j < n; ++j) {
                        const double s = (i + 1.0 / 3) / n, t = (j + 1.0 / 3) / n;
                        positions.push_back(v[a] * (1 - s - t) + v[b] * s + v[c] * t);
                        normals.push_back(to_float(normalized(v[a] + v[b] + v[c])));
                    }
            }
    return block_of(std::move(positions), std::move(normals));
}

TEST(LevelCover, AnIcosahedronIsOfFlatFaces) {
    const PointBlock block = icosahedron_points(20);
    CoverRules rules = rules_for(block, 0.01);
    rules.noise_variance = std::pow(0.002 * rules.diagonal, 2);  // as its edges feign
    rules.sharp = true;
    const std::vector<FittedSurfel> leaves = leaves_of(cover(block, rules));
    for (const FittedSurfel& leaf : leaves)
        EXPECT_LT(leaf.fit_error, 1e-3 * leaf.surfel.support_radius) << leaf.surfel.n_sheets();
    for (const Vec3d& vertex : icosahedron_vertices()) {
        double least = INFINITY;
        for (const FittedSurfel& leaf : leaves) {
            const Vec3d x = (vertex - leaf.surfel.center) / leaf.surfel.support_radius;
            if (sq_length(x) < kTrim * kTrim)
                least = std::min(least, std::abs(leaf.surfel.value(x)));
        }
        EXPECT_LT(least, 1e-6);
    }
}

/// Leaves that miss their points by less than lambda, which edges feign, bend over edges as well;
/// cubics do most of all.
TEST(LevelCover, ASmallIcosahedronOfSeveralPartsIsOfFlatFaces) {
    const PointBlock block = icosahedron_points(12);
    CoverRules rules = rules_for(block, 0.01);
    rules.noise_variance = std::pow(0.002 * rules.diagonal, 2);
    rules.diagonal *= 3;
    rules.sharp = true;
    for (const int degree : {2, 3}) {
        SCOPED_TRACE(degree);
        rules.degree = degree;
        const std::vector<FittedSurfel> leaves = leaves_of(cover(block, rules));
        EXPECT_LE(leaves.size(), 50u);
        for (const FittedSurfel& leaf : leaves)
            EXPECT_LT(leaf.fit_error, 1e-3 * leaf.surfel.support_radius) << leaf.surfel.n_sheets();
    }
}

TEST(LevelCover, NoiseRoundsNothingOff) {
    // Smaller balls are thicker still: tried smaller, leaves would fall apart into single points.
    PointBlock block = block_of(sampled("torus", 20000, 1, 1.6e-3));
    const NoiseVariance noise = measured_noise(block.position, 0, 20000);
    CoverRules rules = rules_for(block, 0.01);
    rules.degree = 1, rules.noise_variance = noise.value, rules.typical_variance = noise.typical;
    const std::uint64_t smooth = cover(block, rules).counts.leaves;
    rules.sharp = true;
    EXPECT_LE(cover(block, rules).counts.leaves, 1.02 * static_cast<double>(smooth));
    rules.typical_variance = 0;  // as if there were none
    EXPECT_GT(cover(block, rules).counts.leaves, 1.2 * static_cast<double>(smooth));
}

TEST(LevelCover, SharpLeavesAreTheSameForAnyNumberOfThreads) {
    const PointBlock block = cube_points(16);
    CoverRules rules = rules_for(block, 0.01);
    rules.sharp = true;
    std::vector<Cover> covers;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        covers.push_back(cover(block, rules));
    }
    for (std::size_t i = 1; i < 3; ++i) {
        expect_same(covers[0], covers[i]);
        for (std::size_t k = 0; k < covers[0].surfels.size(); ++k) {
            const Surfel &a = covers[0].surfels[k].surfel, &b = covers[i].surfels[k].surfel;
            ASSERT_EQ(a.n_sheets(), b.n_sheets());
            for (std::size_t s = 0; s < a.n_sheets(); ++s)
                ASSERT_EQ(a.sheet_polynomial(s).a, b.sheet_polynomial(s).a);
        }
    }
}

TEST(LevelCover, ASmoothSurfaceHasNoSharpLeaves) {
    for (const char* shape : {"sphere", "torus"}) {
        const PointBlock block = block_of(sampled(shape, 6000));
        CoverRules rules = rules_for(block);
        const Cover smooth = cover(block, rules);
        rules.sharp = true;
        const Cover sharp = cover(block, rules);
        ASSERT_EQ(smooth.surfels.size(), sharp.surfels.size());
        for (std::size_t i = 0; i < smooth.surfels.size(); ++i) {
            ASSERT_TRUE(same(smooth.surfels[i], sharp.surfels[i])) << i;
            ASSERT_FALSE(sharp.surfels[i].surfel.sharp);
        }
    }
}

/// The points decide, and what follows is as if they had been told.
TEST(LevelCover, AskedForEdgesTheCoverIsThatOfTheAnswer) {
    const PointBlock cube = cube_points(24), ball = block_of(sampled("sphere", 4000));
    for (const PointBlock* block : {&cube, &ball}) {
        const bool is_part = block == &cube;
        SCOPED_TRACE(is_part ? "cube" : "ball");
        CoverRules rules = rules_for(*block, 0.01);
        rules.spacing = measured_noise(block->position).spacing;
        rules.sharp = is_part;
        const Cover told = cover(*block, rules);
        EXPECT_EQ(told.edges.asked, 0u);
        rules.sharp = !is_part;  // counts for nothing
        rules.ask_for_edges = true;
        const Cover asked = cover(*block, rules);
        EXPECT_EQ(asked.edges.are_features(), is_part);
        EXPECT_GT(asked.edges.asked, 0u);
        expect_same(told, asked);
        EXPECT_EQ(asked.counts.sharp_edges > 0, is_part);
        rules.share = 0.999;  // of a job's sample
        EXPECT_EQ(cover(*block, rules).edges.are_features(), is_part);
    }
}

}  // namespace
}  // namespace slim::test
