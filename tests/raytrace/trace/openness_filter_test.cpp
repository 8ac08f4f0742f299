#include "raytrace/trace/openness_filter.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "tests/raytrace/trace/light_stage.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace slim {
namespace {

using test::camera_at, test::good_sphere, test::Stage;

/// A picture of two level floors, that on the right `step` lower, seen from above: a pixel is 1
/// wide.
struct Floors {
    int width, height;
    Camera camera = camera_at({0, 0, 100}, {0, 0, 0});
    PixelView view;
    GBuffer buffer;
    std::array<std::vector<float>, 3> normals;
    std::vector<float> open;

    Floors(int w, int h, float step, const auto& value)
        : width(w), height(h), view(pixel_view(camera, w, h)) {
        buffer.reset(w, h, kPositionChannel | kNormalChannel);
        open.resize(buffer.n_pixels());
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x) {
                const std::size_t i = buffer.index(x, y);
                buffer.hit[i] = 1;
                buffer.position[0][i] = static_cast<float>(x),
                buffer.position[1][i] = static_cast<float>(-y);
                buffer.position[2][i] = x < w / 2 ? 0 : -step;
                buffer.normal[2][i] = 1;
                open[i] = value(x, y);
            }
        normals = buffer.normal;
    }
    std::vector<float> filtered(int samples) const {
        return filtered_openness({view, {0, 0, width, height}, buffer, normals}, open, samples);
    }
};

/// Between -1 and 1.
float noise(int x, int y) {
    return 2 *
               static_cast<float>(
                   keyed_hash(1, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x),
                              2) >>
                   40) *
               0x1p-24f -
           1;
}

double rms_from(const std::vector<float>& values, float mean) {
    double sq = 0;
    for (const float v : values) sq += static_cast<double>((v - mean) * (v - mean));
    return std::sqrt(sq / static_cast<double>(values.size()));
}

TEST(OpennessFilter, TakesNoiseOfFewSamplesAway) {
    const Floors f(64, 48, 0, [](int x, int y) { return 0.5f + 0.05f * noise(x, y); });
    EXPECT_LT(rms_from(f.filtered(36), 0.5f), 0.3 * rms_from(f.open, 0.5f));
    // Of many samples that is no noise.
    EXPECT_GT(rms_from(f.filtered(4096), 0.5f), 0.9 * rms_from(f.open, 0.5f));
}

// A place of the 4 x 4 has the same samples everywhere: what it differs by is no grain but a
// pattern of stripes.
TEST(OpennessFilter, TakesThePatternOfInterleavedSamplesAway) {
    const auto of_place = [](int x, int y) { return noise(x % 4, y % 4); };
    float mean = 0;
    for (int k = 0; k < 16; ++k) mean += of_place(k % 4, k / 4) / 16;
    const auto value = [&](int x, int y) { return 0.5f + 0.08f * (of_place(x, y) - mean); };
    const Floors f(32, 32, 0, value);
    const auto out = f.filtered(36);
    EXPECT_GT(rms_from(f.open, 0.5f), 0.035);
    for (int y = kOpennessReach; y < 32 - kOpennessReach; ++y)
        for (int x = kOpennessReach; x < 32 - kOpennessReach; ++x)
            EXPECT_NEAR(out[f.buffer.index(x, y)], 0.5f, 0.004) << x << ' ' << y;
}

TEST(OpennessFilter, KeepsEdges) {
    const auto halves = [](int x, int) { return x < 32 ? 0.45f : 0.5f; };
    // Where the surface has a step, however little they differ.
    const Floors step(64, 8, 3, halves);
    const auto out = step.filtered(36);
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], step.open[i], 0.003);
    // And on one surface where they differ by more than noise.
    const Floors shadow(64, 8, 0, [](int x, int) { return x < 32 ? 0.3f : 0.8f; });
    const auto kept = shadow.filtered(36);
    for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_NEAR(kept[i], shadow.open[i], 1e-6);
}

TEST(OpennessFilter, WhatIsNoHitIsNothing) {
    Floors f(16, 16, 0, [](int, int) { return 0.5f; });
    for (int y = 0; y < 16; ++y) {
        const std::size_t i = f.buffer.index(7, y);
        f.buffer.hit[i] = 0, f.open[i] = NAN;
    }
    const auto out = f.filtered(36);
    for (std::size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i], f.buffer.hit[i] ? 0.5f : 0.0f);
}

TEST(OpennessFilter, APartIsThatOfTheWholeInsideItsMargin) {
    const auto value = [](int x, int y) { return 0.5f + 0.05f * noise(x, y); };
    const Floors whole(61, 37, 0.2f, value);
    const auto all = whole.filtered(36);
    constexpr int kLeft = 9, kTop = 5, kWidth = 43, kHeight = 21;
    const Floors part(kWidth, kHeight, 0, [&](int x, int y) { return value(x + kLeft, y + kTop); });
    GBuffer cut = part.buffer;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (const std::size_t a : {0u, 1u, 2u})
                cut.position[a][cut.index(x, y)] =
                    whole.buffer.position[a][whole.buffer.index(x + kLeft, y + kTop)];
    const auto out =
        filtered_openness({part.view, {0, 0, kWidth, kHeight}, cut, part.normals}, part.open, 36);
    for (int y = kOpennessReach; y < kHeight - kOpennessReach; ++y)
        for (int x = kOpennessReach; x < kWidth - kOpennessReach; ++x)
            ASSERT_EQ(out[cut.index(x, y)], all[whole.buffer.index(x + kLeft, y + kTop)])
                << x << ' ' << y;
}

TEST(OpennessFilter, ThreadsDoNotMatter) {
    const Floors f(50, 70, 0.1f, [](int x, int y) { return 0.5f + 0.05f * noise(x, y); });
    std::vector<float> one;
    {
        const ThreadLimit limit(1);
        one = f.filtered(36);
    }
    const ThreadLimit limit(4);
    EXPECT_EQ(f.filtered(36), one);
}

// Of 36 rays a pixel; without the filter it is 0.03.
TEST(OpennessFilter, LittleGrainIsLeftOnASphereAboveTheGround) {
    Stage stage(good_sphere(), camera_at({0, 1, 6}, {0, 0, 0}));
    stage.look.ground = GroundPlane{{0, 1, 0}, -1, {}};
    const auto open = stage.openness(1e4, 36);
    double sq = 0;
    int n = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (!stage.buffer.hit[i]) continue;
        const double off = static_cast<double>(open[i]) - 0.5 * (1 + stage.normal(i).y);
        sq += off * off, ++n;
    }
    EXPECT_LT(std::sqrt(sq / n), 0.012);
}

TEST(SampleGrid, FourByFourPixelsTogetherFillASixteenTimesFinerGrid) {
    constexpr int kSide = 3, kFine = 4 * kSide;
    const SampleGrid grid(kSide * kSide, SampleGrid::Pixels::interleaved);
    for (const int from : {0, 5}) {  // any of them, wherever packets begin
        std::set<std::pair<int, int>> cells;
        for (int y = from; y < from + 4; ++y)
            for (int x = from; x < from + 4; ++x) {
                PixelBlock block;
                block.x = x / kPacketWidth * kPacketWidth,
                block.y = y / kPacketHeight * kPacketHeight;
                const auto lane =
                    static_cast<std::size_t>((y - block.y) * kPacketWidth + x - block.x);
                for (int i = 0; i < grid.n(); ++i) {
                    FloatV s, t;
                    grid.sample(i, LaneKeys(block, 7), s, t);
                    cells.insert(
                        {static_cast<int>(s[lane] * kFine), static_cast<int>(t[lane] * kFine)});
                }
            }
        EXPECT_EQ(cells.size(), static_cast<std::size_t>(kFine * kFine));
    }
}

}  // namespace
}  // namespace slim
