#include "slim/fit/edge_share.h"

#include "slim/base/parallel.h"
#include "tests/slim/fit/noise_support.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

struct Points {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
};

/// Random points on the faces of a box of these sides, with noise of that deviation along their
/// normals and of `tilt` radians in these.
Points box_points(const Vec3d& side, std::size_t n, double noise, double tilt = 0) {
    constexpr std::uint64_t kPlace = 1, kNoise = 2, kTilt = 3;
    const double area[3] = {side.y * side.z, side.x * side.z, side.x * side.y};
    Points out;
    for (std::size_t i = 0; i < n; ++i) {
        double at = (1 + random_at(kPlace, 4 * i)) / 2 * (area[0] + area[1] + area[2]);
        std::size_t axis = 0;
        while (axis < 2 && at > area[axis]) at -= area[axis++];
        Vec3d p, up;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = (1 + random_at(kPlace, 4 * i + 1 + k)) / 2 * side[k];
        const bool far = p[axis] > side[axis] / 2;
        up[axis] = far ? 1 : -1;
        p[axis] = (far ? side[axis] : 0) + up[axis] * noise * gaussian(kNoise, i);
        for (std::size_t k = 0; k < 3; ++k) up[k] += tilt * gaussian(kTilt, 3 * i + k);
        out.positions.push_back(p);
        out.normals.push_back(to_float(normalized(up)));
    }
    return out;
}

EdgeShare share_of(const Points& points, double noise, double share = 1) {
    const double n = static_cast<double>(points.positions.size());
    PointBlock block = along_curve(block_of(points.positions, points.normals));
    const NoiseVariance measured = measured_noise(points.positions, 0, 20000);
    if (share < 1) {
        PointBlock some;
        for (std::size_t i = 0; i < block.size(); ++i) {
            if (!in_share(0, block.id[i], share)) continue;
            some.position.push_back(block.position[i]);
            some.normal.push_back(block.normal[i]);
            some.id.push_back(block.id[i]);
        }
        block = std::move(some);
    }
    const PointPyramid pyramid(block, box_of(block), 0, share);
    return edge_share(block, pyramid,
                      {.spacing = measured.spacing,
                       .n_points = n,
                       .noise_variance = std::max(measured.value, noise * noise),
                       .typical_variance = std::max(measured.typical, noise * noise)});
}

Points surface_points(const char* shape, std::size_t n, double noise) {
    const Cloud cloud = sampled(shape, n, 1, noise);
    return {cloud.positions, cloud.normals};
}

TEST(EdgeShare, ABoxIsAPartAtAnyDensityAndNoise) {
    for (const double noise : {0.0, 0.002, 0.01})
        for (const std::size_t n : {4000u, 40000u, 200000u}) {
            SCOPED_TRACE(testing::Message() << n << " points, noise " << noise);
            const EdgeShare found = share_of(box_points({1, 1.2, 0.8}, n, noise), noise);
            EXPECT_TRUE(found.are_features()) << found.at_edges << " of " << found.asked;
            EXPECT_GT(found.share(), 2 * kEdgeShare);
            EXPECT_LE(found.asked, 96u) << "it is soon sure";
        }
}

TEST(EdgeShare, RoundSurfacesAreNoParts) {
    for (const char* shape : {"sphere", "bumpy", "torus"})
        for (const double noise : {0.0, 0.001, 0.005}) {
            SCOPED_TRACE(testing::Message() << shape << ", noise " << noise);
            const EdgeShare found = share_of(surface_points(shape, 30000, noise), noise);
            EXPECT_FALSE(found.are_features()) << found.at_edges << " of " << found.asked;
            EXPECT_LE(found.asked, 128u) << "it is soon sure";
            EXPECT_GE(found.asked, 64u);
        }
}

/// Two sides back to back, close beside each other against the ball, are one of a wing or an ear.
TEST(EdgeShare, TheSidesOfAThinPlateAreNoEdges) {
    const EdgeShare found = share_of(box_points({1, 1, 0.01}, 40000, 0), 0);
    EXPECT_FALSE(found.are_features()) << found.at_edges << " of " << found.asked;
}

TEST(EdgeShare, NothingIsAskedWhereNoiseIsAsThickAsTheShape) {
    const Points box = box_points({1, 1, 1}, 20000, 0.01);
    EXPECT_TRUE(share_of(box, 0.01).are_features());
    // Of coordinates rounded to steps of 1/8, say, lambda is that of places in different steps.
    EXPECT_EQ(share_of(box, 0.1).asked, 0u);
}

TEST(EdgeShare, AFewEdgesAreNotEnough) {
    Points sphere = surface_points("sphere", 60000, 0);
    const double part_of_box[2] = {0.02, 1.0};
    bool is_part[2];
    for (int k = 0; k < 2; ++k) {
        Points all = sphere;
        const auto n = static_cast<std::size_t>(part_of_box[k] * 60000);
        // As dense as the sphere, whose area is 4 pi, beside it.
        const double side = std::sqrt(4 * 3.14159 * part_of_box[k] / 6);
        const Points box = box_points({side, side, side}, n, 0);
        for (std::size_t i = 0; i < n; ++i) {
            all.positions.push_back(box.positions[i] + Vec3d{3, 0, 0});
            all.normals.push_back(box.normals[i]);
        }
        is_part[k] = share_of(all, 0).are_features();
    }
    EXPECT_FALSE(is_part[0]);
    EXPECT_TRUE(is_part[1]);
}

TEST(EdgeShare, IsTheSameOfASampleAndForAnyNumberOfThreads) {
    for (const Points& points : {box_points({1, 1.2, 0.8}, 100000, 0.002, 0.05),
                                 surface_points("bumpy", 100000, 0.002)}) {
        const EdgeShare whole = share_of(points, 0.002), sample = share_of(points, 0.002, 0.3);
        EXPECT_EQ(whole.asked, sample.asked);
        EXPECT_EQ(whole.at_edges, sample.at_edges);
        const ThreadLimit one(1);
        const EdgeShare alone = share_of(points, 0.002);
        EXPECT_EQ(whole.asked, alone.asked);
        EXPECT_EQ(whole.at_edges, alone.at_edges);
    }
}

TEST(EdgeShare, NothingIsAskedOfFewPointsOrWithoutASpacing) {
    EXPECT_EQ(share_of(box_points({1, 1, 1}, 400, 0), 0).asked, 0u);
    const Points box = box_points({1, 1, 1}, 4000, 0);
    const PointBlock block = along_curve(block_of(box.positions, box.normals));
    const PointPyramid pyramid(block, box_of(block), 0);
    const EdgeShare found = edge_share(block, pyramid, {.n_points = 4000});
    EXPECT_EQ(found.asked, 0u);
    EXPECT_FALSE(found.are_features());
}

TEST(EdgeShare, EvidenceChangesSidesAtTheShareThatIsSaid) {
    EXPECT_LT((EdgeShare{10000, 430}).evidence(), 0);
    EXPECT_GT((EdgeShare{10000, 442}).evidence(), 0);
}

}  // namespace
}  // namespace slim::test
