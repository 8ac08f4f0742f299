#include "slim/normals/estimate.h"

#include "slim/normals/evidence.h"
#include "tests/slim/fit/fit_support.h"
#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

/// About n points of the unit sphere on circles of latitude that are `ratio` times as far from each
/// other as their points; noise along the radius.
PointBlock circles(std::size_t n, double ratio, double noise) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const double spacing = std::sqrt(4 * std::numbers::pi / (static_cast<double>(n) * ratio));
    const auto rows = static_cast<std::size_t>(std::numbers::pi / (spacing * ratio));
    for (std::size_t row = 0; row < rows; ++row) {
        const double t =
            std::numbers::pi * (static_cast<double>(row) + 0.5) / static_cast<double>(rows);
        const double m = std::ceil(2 * std::numbers::pi * std::sin(t) / spacing);
        for (double j = 0; j < m; ++j) {
            const std::size_t i = positions.size();
            const double f = 2 * std::numbers::pi * (j + unit_interval(keyed_hash(1, i))) / m;
            const Vec3d normal{std::sin(t) * std::cos(f), std::sin(t) * std::sin(f), std::cos(t)};
            positions.push_back((1 + noise * gaussian(2, i)) * normal);
            normals.push_back(to_float(normal));
        }
    }
    return along_curve(block_of(positions, normals));
}

std::vector<std::uint32_t> all_of(const PointBlock& block) {
    std::vector<std::uint32_t> all(block.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

/// Share of normals, estimated from k neighbours or more, within 10 degrees of the sphere's.
double share_right(const PointBlock& block, std::size_t k) {
    PointBlock estimated = block;
    std::size_t degenerate = 0;
    const NeighborGraph graph = estimate_normals(estimated, NearestSearch(block.position),
                                                 all_of(block), k, degenerate);
    EXPECT_EQ(graph.n_on_lines, 0u);
    double n = 0;
    for (std::size_t i = 0; i < block.size(); ++i)
        n += std::abs(dot(estimated.normal[i], block.normal[i])) > 0.985f;
    return n / static_cast<double>(block.size());
}

// NUMERICS section 6, 24: scan lines 5:1 to 40:1.
TEST(ScanLines, Row24NormalsAreThoseOfThePatchNotOfTheLine) {
    for (const double ratio : {5.0, 10.0, 20.0, 40.0}) {
        for (const double noise : {0.0, 0.001}) {
            SCOPED_TRACE(testing::Message() << ratio << ", noise " << noise);
            EXPECT_GT(share_right(circles(40000, ratio, noise), 16), 0.99);
        }
    }
}

TEST(ScanLines, Row24ThickNoiseInThePlaneOfALineIsNoPatch) {
    // Noise of three spacings along the lines: sixteen neighbours lie in the plane of their circle.
    const PointBlock block = circles(40000, 40, 0.009);
    const NearestSearch search(block.position);
    const std::size_t k = neighbors_beyond_strips(search, all_of(block), 16);
    EXPECT_GT(k, 16u);
    EXPECT_LT(share_right(block, 16), 0.5);
    EXPECT_GT(share_right(block, k), 0.98);
    // Right normals stand off these planes, but not off those of more neighbours.
    EXPECT_TRUE(evidence_of(block, search, all_of(block)).is_off_surface());
    EXPECT_FALSE(evidence_of(block, search, all_of(block), k).is_off_surface());
}

TEST(ScanLines, NeighboursOfAPlainSurfaceAreNoStrips) {
    for (const double noise : {0.0, 0.003, 0.03}) {
        const PointBlock block = along_curve(block_of(sampled("sculpture", 20000, 1, noise)));
        EXPECT_EQ(neighbors_beyond_strips(NearestSearch(block.position), all_of(block), 16), 16u)
            << noise;
    }
}

TEST(ScanLines, RepeatsSayNothingOfStrips) {
    std::vector<Vec3d> positions;
    for (std::size_t i = 0; i < 300; ++i)
        for (int copy = 0; copy < 40; ++copy)
            positions.push_back(normalized(random_in_cube(7, i)));
    const PointBlock block = along_curve(block_of(positions, std::vector<Vec3f>(positions.size())));
    const NearestSearch search(block.position);
    std::vector<std::uint32_t> repeats;
    for (const std::uint32_t i : all_of(block))
        if (search.is_repeat(i)) repeats.push_back(i);
    EXPECT_EQ(neighbors_beyond_strips(search, repeats, 16), 16u);
}

TEST(ScanLines, PointsThatHaveNothingButALineAreCounted) {
    PointBlock block = circles(20000, 2000, 0);
    std::size_t degenerate = 0;
    const NearestSearch search(block.position);
    std::vector<bool> counted(block.size(), false);
    EXPECT_EQ(
        estimate_normals(block, search, all_of(block), 16, degenerate, counted).n_on_lines, 0u);
    const NeighborGraph graph = estimate_normals(block, search, all_of(block), 16, degenerate);
    EXPECT_GT(graph.n_on_lines, block.size() / 2);
}

/// A ground of 20,000 points, and wires above it, along x.
PointBlock wires_over_ground(int n_wires, double apart) {
    PointBlock block = graph_points(20000, 20, 11, [](double, double) { return 0.0; });
    for (int w = 0; w < n_wires; ++w)
        for (std::size_t i = 0; i < 500; ++i) {
            const std::uint64_t key = 1000 * static_cast<std::uint64_t>(w) + i;
            block.position.push_back({20 * random_at(12, key), apart * w + 0.01 * gaussian(13, key),
                                      8 + 0.01 * gaussian(14, key)});
            block.normal.push_back({0, 0, 1});
            block.id.push_back(block.id.size());
        }
    return along_curve(block);
}

// One wire, or five 60 of their spacings from each other: neither the ground nor the next wire is a
// patch of theirs.
TEST(ScanLines, WiresOverADenseGroundAreNoScanLines) {
    for (const auto& [n_wires, apart] : {std::pair{1, 0.0}, {5, 4.8}}) {
        SCOPED_TRACE(n_wires);
        PointBlock block = wires_over_ground(n_wires, apart);
        std::size_t degenerate = 0;
        const NeighborGraph graph = estimate_normals(block, NearestSearch(block.position),
                                                     all_of(block), 16, degenerate);
        EXPECT_GT(graph.n_on_lines, 490u * static_cast<std::size_t>(n_wires));
        EXPECT_LE(graph.n_on_lines, 500u * static_cast<std::size_t>(n_wires));
    }
}

TEST(ScanLines, Row24NoiseIsThatAcrossThePatch) {
    for (const double ratio : {10.0, 40.0}) {
        SCOPED_TRACE(ratio);
        const double noise = 0.001;
        const NoiseVariance measured =
            measured_noise(circles(100000, ratio, noise).position, 0);
        EXPECT_GT(measured.value, 0.5 * noise * noise);  // a line has none
        EXPECT_LT(measured.value, 4 * noise * noise);    // the patch is curved
    }
}

}  // namespace
}  // namespace slim::test
