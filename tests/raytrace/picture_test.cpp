#include "raytrace/picture.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace slim {
namespace {

TEST(Picture, SrgbCurveHasItsPublishedPointsAndInverts) {
    EXPECT_FLOAT_EQ(srgb_from_linear(0), 0);
    EXPECT_FLOAT_EQ(srgb_from_linear(1), 1);
    EXPECT_NEAR(srgb_from_linear(0.21404114f), 0.5f, 1e-6);  // IEC 61966-2-1
    EXPECT_NEAR(srgb_from_linear(0.0031308f), 0.04045f, 1e-5);
    EXPECT_EQ(srgb_from_linear(std::numeric_limits<float>::quiet_NaN()), 0);
    EXPECT_EQ(srgb_from_linear(7), 1);
    for (int i = 0; i < 256; ++i) {
        const float v = static_cast<float>(i) / 255;
        EXPECT_NEAR(srgb_from_linear(linear_from_srgb(v)), v, 1e-6f);
    }
}

TEST(Picture, EncodingUnpremultiplies) {
    Picture p(1, 1);
    const float linear = linear_from_srgb(128.0f / 255);
    for (int c = 0; c < 3; ++c) p.pixel(0, 0)[c] = 0.25f * linear;
    p.pixel(0, 0)[3] = 0.25f;
    EXPECT_EQ(encode_srgb8(p).rgba, (std::vector<std::uint8_t>{128, 128, 128, 64}));
}

TEST(Picture, BoxFilterAveragesBlocks) {
    Picture p(4, 2);
    for (std::size_t i = 0; i < p.rgba.size(); ++i) p.rgba[i] = static_cast<float>(i);
    const Picture half = box_downsample(p, 2);
    ASSERT_EQ(half.width, 2);
    ASSERT_EQ(half.height, 1);
    EXPECT_FLOAT_EQ(half.pixel(0, 0)[0], (0 + 4 + 16 + 20) / 4.0f);
    EXPECT_FLOAT_EQ(half.pixel(1, 0)[3], (11 + 15 + 27 + 31) / 4.0f);
}

}  // namespace
}  // namespace slim
