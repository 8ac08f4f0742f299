#include "slim/smooth/feature_edges.h"

#include "slim/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace slim::test {
namespace {

/// n by n squares over [0, 1]^2 at the heights z(x, y).
template <class Height>
Mesh sheet(std::size_t n, const Height& z) {
    Mesh mesh;
    for (std::size_t i = 0; i <= n; ++i)
        for (std::size_t k = 0; k <= n; ++k) {
            const double x = double(i) / double(n), y = double(k) / double(n);
            mesh.position.push_back({x, y, z(x, y)});
        }
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t a = i * (n + 1) + k, b = a + n + 1;
            mesh.add_face(std::vector<std::size_t>{a, b, b + 1, a + 1});
        }
    return mesh;
}

/// Roofs side by side, as steep as stairs; a wave with the same rise.
double roofs(double x, double) { return std::abs(std::remainder(x, 0.5)); }
double wave(double x, double) { return 0.125 * std::cos(4 * M_PI * x); }

SmoothModelRules rules() { return {.diagonal = std::sqrt(2.0), .noise_variance = 1e-12}; }

TEST(FeatureEdges, AreThoseOfRoofsNotOfWaves) {
    const EdgesSeen edges = feature_edges(sheet(60, roofs), rules());
    EXPECT_TRUE(edges.are_features()) << edges.share();
    const EdgesSeen none = feature_edges(sheet(60, wave), rules());
    EXPECT_FALSE(none.are_features()) << none.share();
    for (const EdgesSeen& seen : {edges, none}) {
        EXPECT_GE(seen.asked, 128u);
        EXPECT_LE(seen.asked, 512u);
    }
}

TEST(FeatureEdges, AreTheSameForAnyNumberOfThreads) {
    const Mesh mesh = sheet(
        40, [](double x, double y) { return roofs(x, y) + 0.002 * std::sin(400 * x + 300 * y); });
    std::vector<std::size_t> at_edges, asked;
    for (const int threads : {1, 2, 3, 8}) {
        const ThreadLimit limit(threads);
        const EdgesSeen seen = feature_edges(mesh, rules());
        at_edges.push_back(seen.at_edges), asked.push_back(seen.asked);
    }
    EXPECT_GT(at_edges[0], 0u);
    for (std::size_t k = 1; k < 4; ++k) {
        EXPECT_EQ(at_edges[k], at_edges[0]);
        EXPECT_EQ(asked[k], asked[0]);
    }
}

TEST(FeatureEdges, AreNoneOfMeshesWithoutFaces) {
    Mesh mesh = sheet(10, roofs);
    mesh.corner.clear(), mesh.face_end.clear();
    EXPECT_EQ(feature_edges(mesh, rules()).asked, 0u);
    EXPECT_EQ(feature_edges(Mesh{}, rules()).share(), 0);
}

TEST(FeatureEdges, TheDegreeOfTheModelCounts) {
    const Mesh mesh = sheet(60, roofs);
    SmoothModelRules cubic = rules(), chosen = rules();
    cubic.degree = chosen.degree = 3;
    chosen.choose_degree = true;
    const EdgesSeen by_cubics = feature_edges(mesh, cubic), by_choice = feature_edges(mesh, chosen);
    EXPECT_NE(by_cubics.at_edges * by_choice.asked, by_choice.at_edges * by_cubics.asked);
}

}  // namespace
}  // namespace slim::test
