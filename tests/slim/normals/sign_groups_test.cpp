#include "slim/normals/sign_groups.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

constexpr std::size_t kRows = 64;  // of the graph, within which a group stays

/// Points along the curve and their neighbours.
struct SignedCloud {
    PointBlock points;
    NeighborGraph graph;
};

/// Points along the curve with normals of random signs, and the graph of their 8 nearest.
SignedCloud cloud_of(const std::vector<Vec3d>& positions, const std::vector<Vec3f>& normals) {
    SignedCloud cloud{along_curve(block_of(positions, normals)), {}};
    PointBlock& points = cloud.points;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (keyed_hash(11, points.id[i]) % 2) points.normal[i] = -points.normal[i];
    const NearestSearch search(points.position);
    cloud.graph.k = 8;
    for (std::uint32_t i = 0; i < points.size(); ++i) cloud.graph.points.push_back(i);
    cloud.graph.neighbors.resize(8 * points.size());
    search.for_each(cloud.graph.points, 8,
                    [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
                        std::copy_n(neighbors.begin(), 8, cloud.graph.neighbors.begin() +
                                                              static_cast<std::ptrdiff_t>(8 * w));
                    });
    return cloud;
}

SignedCloud plane(std::size_t n) {
    std::vector<Vec3d> positions;
    for (std::uint64_t i = 0; i < n; ++i)
        positions.push_back({random_at(1, i), random_at(2, i), 0});
    return cloud_of(positions, std::vector<Vec3f>(n, Vec3f{0, 0, 1}));
}

std::vector<bool> none_known(const SignedCloud& cloud) {
    return std::vector<bool>(cloud.points.size());
}

/// Normals with the signs that make each agree with its group.
Vec3f in_group(const SignedCloud& cloud, const SignGroups& groups, std::size_t i) {
    return groups.opposed[i] ? -cloud.points.normal[i] : cloud.points.normal[i];
}

TEST(SignGroups, OfAPlaneAreItsRunsAlongTheCurveWithTheirSigns) {
    const SignedCloud cloud = plane(2000);
    const SignGroups groups = group_by_sign(cloud.points, cloud.graph, none_known(cloud));
    std::map<std::uint32_t, std::set<std::size_t>> runs_of;
    std::map<std::uint32_t, float> side_of;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
        const std::uint32_t g = groups.of[i];
        ASSERT_GT(g, SignGroups::kKnown);
        ASSERT_LT(g, groups.n);
        runs_of[g].insert(i / kRows);
        const float side = in_group(cloud, groups, i).z;
        ASSERT_EQ(side_of.try_emplace(g, side).first->second, side) << i;
    }
    EXPECT_EQ(runs_of.size() + 1, groups.n);  // no number is left out
    for (const auto& [group, runs] : runs_of) EXPECT_EQ(runs.size(), 1u) << group;
    // 32 runs, most of them one piece of the plane each.
    EXPECT_LT(groups.n, 2 * 32u);
}

TEST(SignGroups, AllKnownPointsAreOneGroupAndKeepTheirSigns) {
    const SignedCloud cloud = plane(1000);
    std::vector<bool> known = none_known(cloud);
    for (std::size_t i = 0; i < known.size(); ++i) known[i] = i % 3 == 0;
    const SignGroups groups = group_by_sign(cloud.points, cloud.graph, known);
    for (std::size_t i = 0; i < known.size(); ++i) {
        const bool is_known = known[i];
        EXPECT_EQ(groups.of[i] == SignGroups::kKnown, is_known) << i;
        EXPECT_FALSE(is_known && groups.opposed[i]) << i;
    }
}

TEST(SignGroups, PointsThatAreNotInTheGraphAreKnown) {
    SignedCloud cloud = plane(500);
    std::vector<bool> known(500);
    NeighborGraph part{8, {}, {}};
    for (std::uint32_t i = 0; i < 500; ++i) {
        known[i] = i % 2 == 0;
        if (known[i]) continue;
        part.points.push_back(i);
        const auto of = cloud.graph.of(i);
        part.neighbors.insert(part.neighbors.end(), of.begin(), of.end());
    }
    const SignGroups groups = group_by_sign(cloud.points, part, known);
    std::map<std::uint32_t, float> side_of;
    for (std::size_t i = 1; i < 500; i += 2) {
        ASSERT_GT(groups.of[i], SignGroups::kKnown);
        const float side = in_group(cloud, groups, i).z;
        ASSERT_EQ(side_of.try_emplace(groups.of[i], side).first->second, side) << i;
    }
    EXPECT_LT(side_of.size(), 250u / 5);  // joined, though half of the neighbours are not in it
}

TEST(SignGroups, DoNotReachOverAnEdge) {
    // Two faces at a right angle, which meet along the y axis.
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; i < 4000; ++i) {
        const double across = 0.5 + 0.5 * random_at(1, i), along = random_at(2, i);
        const bool upper = i % 2;
        positions.push_back(upper ? Vec3d{across, along, 0} : Vec3d{0, along, -across});
        normals.push_back(upper ? Vec3f{0, 0, 1} : Vec3f{-1, 0, 0});
    }
    const SignedCloud cloud = cloud_of(positions, normals);
    const SignGroups groups = group_by_sign(cloud.points, cloud.graph, none_known(cloud));
    std::map<std::uint32_t, bool> face_of;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
        const bool upper = cloud.points.normal[i].z != 0;
        ASSERT_EQ(face_of.try_emplace(groups.of[i], upper).first->second, upper) << i;
    }
    EXPECT_LT(groups.n, 4000u / 5);
}

/// Normals of a plane, each turned by up to so many degrees.
SignedCloud rough_plane(std::size_t n, double most_deg) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; i < n; ++i) {
        positions.push_back({random_at(1, i), random_at(2, i), 0});
        const double lean = most_deg * std::numbers::pi / 180 * unit_interval(keyed_hash(3, i)),
                     way = 2 * std::numbers::pi * unit_interval(keyed_hash(4, i));
        normals.push_back(to_float(Vec3d{std::sin(lean) * std::cos(way),
                                         std::sin(lean) * std::sin(way), std::cos(lean)}));
    }
    return cloud_of(positions, normals);
}

// Sure pairs alone would leave groups of one and two points.
TEST(SignGroups, InThickNoiseLessAlikeNeighboursAreJoined) {
    const SignedCloud cloud = rough_plane(4000, 85);
    std::size_t n_sure = 0, n_pairs = 0;
    for (std::size_t i = 0; i < cloud.points.size(); ++i)
        for (const std::uint32_t j : cloud.graph.of(i)) {
            n_pairs += i != j;
            n_sure +=
                i != j && std::abs(dot(cloud.points.normal[i], cloud.points.normal[j])) > 0.9f;
        }
    ASSERT_LT(4 * n_sure, n_pairs);
    const SignGroups groups = group_by_sign(cloud.points, cloud.graph, none_known(cloud));
    EXPECT_LE(5 * groups.n, cloud.points.size());
}

/// The vote of two neighbours, in doubles.
double vote(const PointBlock& points, std::size_t a, std::size_t b) {
    const Vec3d line = normalized(points.position[b] - points.position[a]);
    const Vec3d m = to_double(points.normal[a]), n = to_double(points.normal[b]);
    return dot(m, n) - dot(m, line) * dot(n, line);
}

TEST(SignVotes, AreTheSumsOverAllPairsOfTwoGroups) {
    const SignedCloud cloud = rough_plane(3000, 40);
    std::vector<bool> known = none_known(cloud);
    for (std::size_t i = 0; i < known.size(); ++i) known[i] = i % 50 == 0;
    const SignGroups groups = group_by_sign(cloud.points, cloud.graph, known);
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> expected;
    for (std::size_t i = 0; i < cloud.points.size(); ++i)
        for (const std::uint32_t j : cloud.graph.of(i)) {
            const auto pair = std::minmax(groups.of[i], groups.of[j]);
            if (pair.first == pair.second) continue;
            const double v = vote(cloud.points, i, j);
            const bool alike = groups.opposed[i] == groups.opposed[j];
            expected[{pair.first, pair.second}] += (alike ? 1 : -1) * v * std::abs(v);
        }
    const std::vector<SignVote> votes = votes_between(cloud.points, cloud.graph, groups);
    ASSERT_GT(votes.size(), 50u);
    ASSERT_EQ(votes.size(), expected.size());
    auto next = expected.begin();
    for (const SignVote& v : votes) {  // in order, each pair once
        ASSERT_EQ((std::pair{v.a, v.b}), next->first);
        EXPECT_NEAR(v.weight, next->second, 1e-4 * (1 + std::abs(next->second)));
        ++next;
    }
}

TEST(SignGroups, AndVotesAreTheSameForAnyNumberOfThreads) {
    const SignedCloud cloud = rough_plane(5000, 60);
    std::vector<SignGroups> groups;
    std::vector<std::vector<SignVote>> votes;
    for (const int n : {1, 3}) {
        const ThreadLimit limit(n);
        groups.push_back(group_by_sign(cloud.points, cloud.graph, none_known(cloud)));
        votes.push_back(votes_between(cloud.points, cloud.graph, groups.back()));
    }
    EXPECT_EQ(groups[0].of, groups[1].of);
    EXPECT_EQ(groups[0].opposed, groups[1].opposed);
    ASSERT_EQ(votes[0].size(), votes[1].size());
    for (std::size_t k = 0; k < votes[0].size(); ++k)
        EXPECT_EQ(votes[0][k].weight, votes[1][k].weight);
}

}  // namespace
}  // namespace slim::test
