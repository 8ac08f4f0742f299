#include "pipeline/build/read_ahead.h"

#include "tests/pipeline/build/normals_stage_support.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace slim::test {
namespace {

class ReadAheadTest : public NormalsStage {
protected:
    /// A sphere in three slices, none of which has normals yet.
    void SetUp() override {
        slice(write(sampled("sphere", 20000), "c.ply"), 3);
        config_.work = file("work");
        plan_ = read_plan(config_.work);
        ASSERT_EQ(plan_.slices.size(), 3u);
    }

    NormalsConfig config_;
    SlicePlan plan_;
    ReadAhead ahead_;
};

TEST_F(ReadAheadTest, GivesWhatReadingInTurnGivesOnce) {
    ahead_.read(config_, plan_, 1);
    const std::optional<PointBlock> points = ahead_.take(1);
    ASSERT_TRUE(points);
    const PointBlock in_turn = read_with_rims(config_, plan_, 1, std::nullopt);
    EXPECT_GT(points->size(), plan_.slices[1].n_points);  // with its rim
    EXPECT_TRUE(points->position == in_turn.position && points->normal == in_turn.normal &&
                points->id == in_turn.id);
    EXPECT_FALSE(ahead_.take(1));
}

TEST_F(ReadAheadTest, HoldsNothingForASliceThatDoesNotComeNext) {
    ahead_.read(config_, plan_, 1);
    EXPECT_FALSE(ahead_.take(2));
    EXPECT_FALSE(ahead_.take(1));
    ahead_.read(config_, plan_, std::nullopt);
    EXPECT_FALSE(ahead_.take(0));
}

TEST_F(ReadAheadTest, PassesOverASliceThatMayBeUpToDate) {
    const std::string done = manifest_path(oriented_points_path(config_.work, 1)).string();
    normals();
    ahead_.read(config_, plan_, 1);
    EXPECT_FALSE(ahead_.take(1));
    std::filesystem::remove(done);
    ahead_.read(config_, plan_, 1);
    EXPECT_TRUE(ahead_.take(1));
}

TEST_F(ReadAheadTest, LeavesADamagedSliceToItsTurn) {
    const std::string points = slice_points_path(config_.work, 1).string();
    std::filesystem::resize_file(points, std::filesystem::file_size(points) / 2);
    ahead_.read(config_, plan_, 1);
    EXPECT_FALSE(ahead_.take(1));
    EXPECT_EQ(code_of([&] { normals(); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("slice_0001"), std::string::npos) << message_;
}

TEST_F(ReadAheadTest, ChangesNoByte) {
    std::vector<std::string> alone;
    for (int i = 0; i < 3; ++i) {
        config_.slice = i;
        normals(config_);
        alone.push_back(
            hash_file(oriented_points_path(config_.work, static_cast<std::size_t>(i))));
    }
    config_.slice = kAllSlices;
    for (std::size_t i = 0; i < 3; ++i)
        std::filesystem::remove(manifest_path(oriented_points_path(config_.work, i)));
    normals(config_);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(hash_file(oriented_points_path(config_.work, i)), alone[i]) << i;
}

}  // namespace
}  // namespace slim::test
