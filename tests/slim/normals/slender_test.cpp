#include "slim/normals/estimate.h"
#include "slim/normals/evidence.h"
#include "slim/normals/orient.h"

#include "tests/slim/fit/fit_support.h"
#include "tests/slim/normals/normals_support.h"
#include "tests/slim/normals/slender_support.h"

#include <gtest/gtest.h>

#include <numeric>
#include <optional>
#include <vector>

namespace slim::test {
namespace {

std::vector<std::uint32_t> all_of(const PointBlock& block) {
    std::vector<std::uint32_t> all(block.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

/// The block, in order, with normals estimated anew.
OrientReport orient(PointBlock& block, const std::optional<WholeScene>& whole = std::nullopt,
                    const std::vector<bool>& counted = {}) {
    std::size_t degenerate = 0;
    NeighborGraph graph = estimate_normals(block, NearestSearch(block.position), all_of(block), 16,
                                           degenerate);
    std::vector<bool> known(block.size(), false);
    return orient_by_neighbors(block, std::move(graph), known, whole, {}, counted);
}

double share_outwards(const PointBlock& points) {
    PointBlock block = along_curve(points);
    const std::vector<Vec3f> truth = block.normal;
    orient(block);
    return share_agreeing(block, truth);
}

TEST(Slender, RodsFaceOutwardsEachByItself) {
    for (const double length : {0.5, 2.0, 8.0}) {  // 5:1 to 80:1
        PointBlock rods;
        for (int k = 0; k < 8; ++k)
            add_rod(rods, {0.4 * (k % 4), 0.4 * (k / 4), 0}, {0.01, 0.02, length}, 0.05, 6000);
        EXPECT_GT(share_outwards(rods), 0.999) << length;
    }
}

TEST(Slender, RingsFaceOutwards) {
    PointBlock rings;
    for (int k = 0; k < 6; ++k) add_ring(rings, {2.5 * k, 0, 0}, 1, 0.03, 15000);
    EXPECT_GT(share_outwards(rings), 0.999);
}

TEST(Slender, APipeOnTheGroundFacesOutwardsAndTheGroundUp) {
    PointBlock scene = graph_points(20000, 1, 3, [](double, double) { return -0.1; });
    const std::size_t n_ground = scene.size();
    add_rod(scene, {0, 0, 0}, {0, 0, 2}, 0.1, 12000, false);
    EXPECT_GT(share_outwards(scene), 0.999);
    EXPECT_GT(scene.size(), n_ground);
}

TEST(Slender, AWallStaysOpen) {
    // Two sides of a wall that is scanned from the south, and a dent: nothing is enclosed.
    PointBlock wall = graph_points(20000, 1, 4, [](double u, double v) {
        return 0.3 * std::sin(3 * u) * std::sin(2 * v);
    });
    PointBlock block = along_curve(wall);
    EXPECT_TRUE(orient(block).flat);
    for (const Vec3f& n : block.normal) ASSERT_GT(n.z, 0);
}

// A piece of a sphere far from the middle of the whole cloud: its own points say nothing of the
// outside, the sample of the whole does.
TEST(Slender, APieceThatReachesOutOfItsSliceIsTurnedAsTheSampleHasIt) {
    for (const bool inwards : {false, true}) {
        SCOPED_TRACE(inwards);
        PointBlock piece;
        const PointBlock sphere = block_of(sampled("sphere", 20000));
        for (std::size_t i = 0; i < sphere.size(); ++i)
            if (sphere.position[i].x < -0.3)
                add_point(piece, sphere.position[i] + Vec3d{20, 0, 0}, to_double(sphere.normal[i]));
        piece = along_curve(piece);
        const std::vector<Vec3f> truth = piece.normal;
        std::vector<SampledNormal> sampled;
        for (std::uint32_t i = 0; i < piece.size(); i += 50)
            sampled.push_back({i, inwards ? -truth[i] : truth[i]});
        std::vector<bool> own(piece.size());
        for (std::size_t i = 0; i < piece.size(); ++i) own[i] = piece.position[i].x < 19.6;
        orient(piece, WholeScene{{}, true, sampled, false}, own);
        EXPECT_EQ(share_agreeing(piece, truth), inwards ? 0 : 1);
    }
}

// What lies in a slice as a whole needs none.
TEST(Slender, APartWithinItsSliceIsTurnedByItsOwnShape) {
    PointBlock block = block_of(sampled("sphere", 5000));
    for (Vec3d& p : block.position) p = p + Vec3d{50, 20, -30};
    block = along_curve(block);
    const std::vector<Vec3f> truth = block.normal;
    orient(block, WholeScene{}, std::vector<bool>(block.size(), true));
    EXPECT_EQ(share_agreeing(block, truth), 1);
}

NormalEvidence evidence_of_sample(const PointBlock& block, std::size_t n) {
    std::vector<std::uint32_t> samples;
    for (std::size_t i = 0; i < n; ++i)
        samples.push_back(static_cast<std::uint32_t>(i * block.size() / n));
    return evidence_of(block, NearestSearch(block.position), samples);
}

TEST(Slender, InwardNormalsOfPipesAreToldAndOutwardOnesAreNot) {
    for (const int n_pipes : {1, 2, 4}) {
        SCOPED_TRACE(n_pipes);
        PointBlock pipes;
        for (int k = 0; k < n_pipes; ++k)
            add_rod(pipes, {3, 1.0 * k, 0}, {0, 0, 2}, 0.1, 10000, false);
        pipes = along_curve(pipes);
        EXPECT_FALSE(evidence_of_sample(pipes, 2000).is_inward());
        for (Vec3f& n : pipes.normal) n = -n;
        EXPECT_TRUE(evidence_of_sample(pipes, 2000).is_inward());
    }
}

}  // namespace
}  // namespace slim::test
