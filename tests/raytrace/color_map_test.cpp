#include "raytrace/color_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace slim {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

int byte(float v) { return static_cast<int>(std::lround(v * 255)); }

void expect_bytes(const Vec3f& c, int r, int g, int b, int tolerance) {
    EXPECT_NEAR(byte(c.x), r, tolerance);
    EXPECT_NEAR(byte(c.y), g, tolerance);
    EXPECT_NEAR(byte(c.z), b, tolerance);
}

/// Rec.709 luminance.
double luminance(const Vec3f& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

ValueRange range_of(const std::vector<float>& values, const std::vector<std::uint8_t>& hit,
                    double flat = 0) {
    return symmetric_range(percentile_of_abs(values, hit, 95, flat), 1e-3);
}

// Moreland's own table of the map: both ends, the middle, and the quarter points.
TEST(ColorMap, CoolWarmIsMorelandsTable) {
    expect_bytes(cool_warm().srgb(0), 59, 76, 192, 1);
    expect_bytes(cool_warm().srgb(0.25f), 141, 176, 254, 2);
    expect_bytes(cool_warm().srgb(0.5f), 221, 221, 221, 1);
    expect_bytes(cool_warm().srgb(0.75f), 244, 152, 122, 3);
    expect_bytes(cool_warm().srgb(1), 180, 4, 38, 1);
}

TEST(ColorMap, CoolWarmIsAsBrightOnEitherSideAndBrightestInTheMiddle) {
    for (int i = 1; i <= 20; ++i) {
        const float t = static_cast<float>(i) / 40;
        const double cool = luminance(cool_warm().linear(0.5f - t));
        const double warm = luminance(cool_warm().linear(0.5f + t));
        EXPECT_NEAR(std::cbrt(cool), std::cbrt(warm), 0.07) << t;
        EXPECT_LT(cool, luminance(cool_warm().linear(0.5f - t + 0.025f))) << t;
        EXPECT_LT(warm, luminance(cool_warm().linear(0.5f + t - 0.025f))) << t;
    }
}

TEST(ColorMap, SequentialMapsHaveTheirEndsAndGrowBrighter) {
    expect_bytes(viridis().srgb(0), 0x44, 0x01, 0x54, 0);
    expect_bytes(viridis().srgb(1), 0xfd, 0xe7, 0x25, 0);
    expect_bytes(cividis().srgb(0), 0x00, 0x22, 0x4e, 0);
    expect_bytes(cividis().srgb(1), 0xfe, 0xe8, 0x38, 0);
    for (const ColorMap* map : {&viridis(), &cividis()})
        for (int i = 1; i <= 64; ++i)
            EXPECT_GT(luminance(map->linear(static_cast<float>(i) / 64)),
                      luminance(map->linear(static_cast<float>(i - 1) / 64)))
                << map->name() << ' ' << i;
}

TEST(ColorMap, NiceCeilingRoundsUpToRoundNumbers) {
    EXPECT_DOUBLE_EQ(nice_ceiling(1), 1);
    EXPECT_DOUBLE_EQ(nice_ceiling(1.01), 1.2);
    EXPECT_DOUBLE_EQ(nice_ceiling(0.0231), 0.025);
    EXPECT_DOUBLE_EQ(nice_ceiling(87), 100);
    EXPECT_EQ(nice_ceiling(0.14), 0.15);  // as it is written, not 0.15000000000000002
    EXPECT_EQ(nice_ceiling(1.4e-9), 1.5e-9);
    EXPECT_DOUBLE_EQ(nice_ceiling(1.4e-30), 1.5e-30);
    EXPECT_DOUBLE_EQ(nice_ceiling(0), 0);
    EXPECT_DOUBLE_EQ(nice_ceiling(kNaN), 0);
}

TEST(ColorMap, PercentileCountsOnlyFiniteHits) {
    std::vector<float> values;
    std::vector<std::uint8_t> hit;
    for (int i = 1; i <= 100; ++i) {
        values.push_back(static_cast<float>(i % 2 ? i : -i));
        hit.push_back(1);
    }
    for (const float v : {1e9f, kNaN, std::numeric_limits<float>::infinity()}) {
        values.push_back(v);
        hit.push_back(std::isfinite(v) ? 0 : 1);
    }
    EXPECT_DOUBLE_EQ(percentile_of_abs(values, hit, 95), 95);
    EXPECT_DOUBLE_EQ(percentile_of_abs(values, hit, 100), 100);
    EXPECT_DOUBLE_EQ(percentile_of_abs(values, hit, 0), 1);
    const ValueRange range = range_of(values, hit);
    EXPECT_DOUBLE_EQ(range.lo, -100);
    EXPECT_DOUBLE_EQ(range.hi, 100);
    const ValueRange full = full_range(values, hit);
    EXPECT_DOUBLE_EQ(full.lo, -100);
    EXPECT_DOUBLE_EQ(full.hi, 99);
}

TEST(ColorMap, FlatFacesLeaveCurvedOnesTheirRange) {
    // A part: 97 of 100 pixels are flat but for rounding, the others are rounded by 0.3.
    std::vector<float> values(10000, 1e-17f);
    const std::vector<std::uint8_t> hit(values.size(), 1);
    for (std::size_t i = 0; i < values.size(); i += 33) values[i] = i % 2 ? 0.3f : -0.29f;
    EXPECT_DOUBLE_EQ(range_of(values, hit).hi, 1e-3);
    EXPECT_DOUBLE_EQ(range_of(values, hit, 0.01).hi, 0.3);
    // A plane with a few wild pixels is a plane.
    std::vector<float> plane(10000, 1e-4f);
    for (std::size_t i = 0; i < 9; ++i) plane[i] = 5;
    EXPECT_DOUBLE_EQ(range_of(plane, hit, 0.01).hi, 1e-3);
    // Of a scan some is flat: the same as without.
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = 0.00002f * static_cast<float>(i % 700);
    EXPECT_DOUBLE_EQ(range_of(values, hit, 0.01).hi, range_of(values, hit).hi);
}

TEST(ColorMap, ZeroIsNeutralWhateverTheEndsOfASignedRange) {
    const ValueRange uneven{-10, 300, true}, above{10, 300, true}, below{-300, -10, true};
    EXPECT_FLOAT_EQ(place_on_map(uneven, 0), 0.5f);
    EXPECT_FLOAT_EQ(place_on_map(uneven, -10), 0);
    EXPECT_FLOAT_EQ(place_on_map(uneven, -5), 0.25f);
    EXPECT_FLOAT_EQ(place_on_map(uneven, 150), 0.75f);
    EXPECT_FLOAT_EQ(place_on_map(uneven, 999), 1);
    EXPECT_FLOAT_EQ(place_on_map(above, -5), place_on_map(above, 10));
    EXPECT_GT(place_on_map(above, 10), 0.5f);
    EXPECT_FLOAT_EQ(place_on_map(below, -10), 0.5f - 0.5f / 30);
    EXPECT_FLOAT_EQ(place_on_map({-10, 300}, 145), 0.5f);  // one that is not about zero
    const std::vector<float> values{0, -10, 300};
    const std::vector<std::uint8_t> hit{1, 1, 1};
    const Picture8 out = encode_srgb8(paint(3, 1, cool_warm(), uneven, values, hit));
    const std::vector<std::uint8_t> expected{221, 221, 221, 255, 59, 76, 192, 255, 180, 4, 38, 255};
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(out.rgba[i], expected[i], 1) << i;
}

TEST(ColorMap, RangeOfNothingAndOfRoundingErrorsIsSane) {
    const std::vector<float> values{0, 1e-12f, -1e-12f};
    const std::vector<std::uint8_t> hit{1, 1, 1}, none{0, 0, 0};
    EXPECT_DOUBLE_EQ(range_of(values, hit).hi, 1e-3);
    EXPECT_DOUBLE_EQ(range_of(values, none).hi, 1e-3);
    EXPECT_LT(full_range(values, none).lo, full_range(values, none).hi);
    const std::vector<float> constant{3, 3, 3};
    EXPECT_LT(full_range(constant, hit).lo, full_range(constant, hit).hi);
}

TEST(ColorMap, PaintsHitsOnlyAndNeverANaN) {
    const std::vector<float> values{-9, 0, 9, 0, kNaN};
    const std::vector<std::uint8_t> hit{1, 1, 1, 0, 1};
    const Picture8 out = encode_srgb8(paint(5, 1, cool_warm(), {-2, 2}, values, hit));
    const std::vector<std::uint8_t> expected{59, 76, 192, 255, 221, 221, 221, 255, 180, 4,
                                             38, 255, 0,   0,   0,   0,   0,   0,   0,  0};
    ASSERT_EQ(out.rgba.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(out.rgba[i], expected[i], i % 4 == 3 ? 0 : 1) << i;
}

TEST(ColorMap, PaintedValuesAreDisplayReferred) {
    std::vector<float> values;
    for (int i = 0; i <= 256; ++i) values.push_back(static_cast<float>(i) / 256);
    const std::vector<std::uint8_t> hit(values.size(), 1);
    const Picture8 out = encode_srgb8(paint(257, 1, viridis(), {0, 1}, values, hit));
    const auto near = [](int painted, float srgb) { return std::abs(painted - byte(srgb)) <= 1; };
    for (std::size_t i = 0; i < values.size(); ++i) {  // one step: a half may be rounded either way
        const Vec3f c = viridis().srgb(values[i]);
        EXPECT_TRUE(near(out.rgba[4 * i], c.x)) << i;
        EXPECT_TRUE(near(out.rgba[4 * i + 1], c.y)) << i;
        EXPECT_TRUE(near(out.rgba[4 * i + 2], c.z)) << i;
    }
}

}  // namespace
}  // namespace slim
