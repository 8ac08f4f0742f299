#include "slim/model/distinct_points.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

bool always(const Vec3d&) { return true; }

PointBlock block_of(const std::vector<std::pair<Vec3d, Vec3f>>& points) {
    PointBlock block;
    for (const auto& [position, normal] : points) {
        block.id.push_back(block.position.size());
        block.position.push_back(position);
        block.normal.push_back(normal);
        block.scan.push_back(static_cast<std::uint16_t>(block.position.size()));
    }
    return block;
}

TEST(DistinctPoints, CopiesAreOnePointWithTheDirectionOfAllTheirNormals) {
    PointBlock block = block_of({{{0, 0, 0}, {0, 0, 1}},
                                 {{1, 0, 0}, {0, 0, 1}},
                                 {{1, 0, 0}, {0, 0.6f, 0.8f}},
                                 {{1, 0, 0}, {0, 0, 1}},
                                 {{2, 0, 0}, {0, 0.6f, 0.8f}}});
    EXPECT_EQ(keep_distinct(block, always), 2u);
    ASSERT_EQ(block.size(), 3u);
    EXPECT_EQ(block.id, (std::vector<std::uint64_t>{0, 1, 4}));
    EXPECT_EQ(block.scan, (std::vector<std::uint16_t>{1, 2, 5}));
    const Vec3f mean = normalized(Vec3f{0, 0.6f, 2.8f});
    EXPECT_NEAR(length(block.normal[1] - mean), 0, 1e-6f);
    EXPECT_EQ(block.normal[2], (Vec3f{0, 0.6f, 0.8f}));  // untouched
}

TEST(DistinctPoints, FacesAtAnEdgeAndSidesOfASheetStay) {
    PointBlock block = block_of({{{0, 0, 0}, {0, 0, 1}},
                                 {{0, 0, 0}, {1, 0, 0}},
                                 {{0, 0, 0}, {0, 0, -1}},
                                 {{0, 0, 0}, {1, 0, 0}},
                                 {{0, 0, 0}, {0, 0, 1}}});
    EXPECT_EQ(keep_distinct(block, always), 2u);
    EXPECT_EQ(block.normal, (std::vector<Vec3f>{{0, 0, 1}, {1, 0, 0}, {0, 0, -1}}));
}

TEST(DistinctPoints, WithoutNormalsThePlaceDecidesAndAZeroNormalGivesWay) {
    PointBlock bare = block_of({{{0, 0, 0}, {}}, {{0, 0, 0}, {}}, {{0, 0, 1}, {}}});
    bare.normal.clear();
    EXPECT_EQ(keep_distinct(bare, always), 1u);
    EXPECT_EQ(bare.size(), 2u);
    PointBlock unmeasured = block_of({{{0, 0, 0}, {}}, {{0, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {}}});
    EXPECT_EQ(keep_distinct(unmeasured, always), 2u);
    EXPECT_EQ(unmeasured.normal, (std::vector<Vec3f>{{0, 1, 0}}));
}

TEST(DistinctPoints, OnlyWhatIsAskedForCounts) {
    PointBlock block = block_of({{{0, 0, 0}, {0, 0, 1}},
                                 {{0, 0, 0}, {0, 0, 1}},
                                 {{5, 0, 0}, {0, 0, 1}},
                                 {{5, 0, 0}, {0, 0, 1}}});
    EXPECT_EQ(keep_distinct(block, [](const Vec3d& p) { return p.x > 1; }), 1u);
    EXPECT_EQ(block.size(), 2u);
    PointBlock none;
    EXPECT_EQ(keep_distinct(none, always), 0u);
}

}  // namespace
}  // namespace slim
