#include "pipeline/build/input_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

Bbox cube_at(const Vec3d& lo, double side = 1) { return {lo, lo + Vec3d{side, side, side}}; }

std::string text_for(const std::vector<Bbox>& boxes) {
    std::vector<std::string> paths;
    for (std::size_t i = 0; i < boxes.size(); ++i)
        paths.push_back("cloud_" + std::to_string(i) + "_");
    return other_frame_text(paths, boxes);
}

/// Unit tiles that touch, row after row.
std::vector<Bbox> tiles(int columns, int rows) {
    std::vector<Bbox> out;
    for (int k = 0; k < rows; ++k)
        for (int i = 0; i < columns; ++i) out.push_back(cube_at({double(i), double(k), 0}));
    return out;
}

TEST(InputFrames, TilesOfOneSurveyAreOfOneFrameHoweverMany) {
    for (const auto& boxes : {tiles(20, 1), tiles(1, 300), tiles(14, 14), tiles(60, 60)})
        EXPECT_EQ(text_for(boxes), "");
}

TEST(InputFrames, OrderDoesNotMatter) {
    std::vector<Bbox> boxes = tiles(40, 1);
    for (std::size_t i = 0; i < 20; ++i) std::swap(boxes[i], boxes[(i * 17) % 40]);
    EXPECT_EQ(text_for(boxes), "");
    boxes.insert(boxes.begin() + 7, cube_at({5e5, 5e6, 0}));
    EXPECT_NE(text_for(boxes).find("cloud_7_"), std::string::npos) << text_for(boxes);
}

TEST(InputFrames, ACloudBesideARowOfTilesIsTold) {
    std::vector<Bbox> boxes = tiles(20, 1);
    boxes.push_back(cube_at({500000, 0, 0}));
    const std::string text = text_for(boxes);
    for (const char* part : {"cloud_0_", "cloud_20_", "(500000, 0, 0)", "same frame?"})
        EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
    // two clouds that are as far off, and one without points
    boxes.insert(boxes.end(), {cube_at({500001, 0, 0}), {}});
    EXPECT_NE(text_for(boxes).find("same frame?"), std::string::npos);
}

TEST(InputFrames, AGapCountsOverTheLargerDiagonal) {
    const double reach = 10 * std::sqrt(3.0);
    EXPECT_EQ(text_for({cube_at({0, 0, 0}), cube_at({1 + reach - 0.01, 0, 0})}), "");
    EXPECT_NE(text_for({cube_at({0, 0, 0}), cube_at({1 + reach + 0.01, 0, 0})}), "");
    EXPECT_EQ(text_for({cube_at({0, 0, 0}), cube_at({100, 0, 0}, 20)}), "");
}

TEST(InputFrames, CloudsWithoutPointsOrSizeSayNothingByThemselves) {
    EXPECT_EQ(text_for({}), "");
    EXPECT_EQ(text_for({cube_at({0, 0, 0})}), "");
    EXPECT_EQ(text_for({cube_at({0, 0, 0}), {}, {}}), "");
    EXPECT_EQ(text_for({cube_at({0, 0, 0}, 0), cube_at({1e6, 0, 0}, 0)}), "");  // two single points
    EXPECT_NE(text_for({cube_at({0, 0, 0}), cube_at({1e6, 0, 0}, 0)}), "");
}

}  // namespace
}  // namespace slim::test
