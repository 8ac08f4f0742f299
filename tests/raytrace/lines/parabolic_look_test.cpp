#include "raytrace/lines/parabolic_look.h"

#include "raytrace/lines/extract.h"
#include "tests/raytrace/lines/analytic_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slim {
namespace {

constexpr int kSize = 300;
constexpr double kWidth = 3, kWave = 1;  // seen, and of one wave along z

/// What bends by 2 along y and in waves so high along z, as far as curvatures go; flat in space.
/// Surfels leave `error`.
GBuffer waves(float height, float error) {
    const PixelView view = pixel_view(test::camera_from_x(kWidth), kSize, kSize);
    GBuffer b;
    b.reset(kSize, kSize, kAllChannels);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const std::size_t i = b.index(x, y);
            const Vec3d p = view.point_at(x + 0.5, y + 0.5, 10);
            const double per_length = 2 * std::numbers::pi / kWave;
            const auto k = height * static_cast<float>(per_length * per_length *
                                                       std::sin(per_length * (p.z + 0.1)));
            b.hit[i] = 1, b.fit_error[i] = error;
            b.position[1][i] = static_cast<float>(p.y), b.position[2][i] = static_cast<float>(p.z);
            b.normal[0][i] = 1;
            b.k1[i] = 2, b.k2[i] = k, b.gauss[i] = 2 * k;
        }
    return b;
}

std::vector<FeatureLine> parabolic_lines(const GBuffer& b) {
    const PixelView view = pixel_view(test::camera_from_x(kWidth), kSize, kSize);
    return extract_lines({b, view, 4, 2}, std::vector{LineKind::parabolic});
}

TEST(ParabolicLook, WavesHigherThanTheErrorHaveLinesFromSideToSide) {
    for (const float height : {0.02f, 0.005f}) {
        const auto lines = parabolic_lines(waves(height, 0.001f));
        ASSERT_EQ(lines.size(), 6u) << height;
        for (const FeatureLine& line : lines) EXPECT_NEAR(line.length, kWidth, 0.05);
    }
}

TEST(ParabolicLook, WavesThatTheErrorMayMakeHaveNone) {
    EXPECT_TRUE(parabolic_lines(waves(0.0003f, 0.001f)).empty());
    EXPECT_TRUE(parabolic_lines(waves(1e-6f, 0)).empty());
}

TEST(ParabolicLook, EvidenceIsTheHeightOfTheLesserSideOverTheError) {
    const GBuffer b = waves(0.002f, 0.001f);
    const PixelView view = pixel_view(test::camera_from_x(kWidth), kSize, kSize);
    CurvatureSamples samples;
    samples.add({b, view, 4, 2});
    // Level lines of the picture where sin is 0, away from its upper and lower border.
    FeatureLine line;
    line.kind = LineKind::parabolic;
    const float row = static_cast<float>(kSize / 2 + 0.1 * kSize / kWidth);
    for (int x = 50; x < 250; ++x) {
        const float y = static_cast<float>((x + 0.5 - kSize / 2) * kWidth / kSize);
        line.points.push_back({static_cast<float>(x) + 0.5f, row, {0, y, -0.1f}, 2, 0});
    }
    std::vector<FeatureLine> lines{line};
    look_across_parabolic(lines, samples, 4, 1);
    for (const LinePoint& p : lines[0].points) EXPECT_NEAR(p.evidence, 2, 0.2);
}

}  // namespace
}  // namespace slim
