#include "formats/image_io.h"
#include "pipeline/measure/measure_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"
#include "tests/pipeline/measure/measure_ways_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slim::test {
namespace {

using nlohmann::json;

class MeasurePictures : public MeasureWays {};

TEST_F(MeasurePictures, PicturesDifferWhereTheyDo) {
    const std::string a = png("a.png", {255, 0, 0, 255, 10, 20, 30, 255});
    const std::string b = png("b.png", {255, 0, 0, 255, 10, 71, 30, 255});
    const json same = measured(a, a, [](MeasureConfig&) {});
    EXPECT_EQ(same["identical"], true);
    EXPECT_EQ(same["above"], 0.0);
    const json m = measured(a, b, [&](MeasureConfig& c) { c.output = file("d.png"); });
    EXPECT_NEAR(m["max"].get<double>(), 51 / 255.0, 1e-12);
    EXPECT_NEAR(m["rms"].get<double>(), 51 / 255.0 / std::sqrt(8.0), 1e-12);
    EXPECT_DOUBLE_EQ(m["above"].get<double>(), 0.5);
    EXPECT_EQ(m["max_at"], json({1, 0}));
    EXPECT_EQ(m["channels"]["R"]["max"], 0.0);
    const PngImage d = read_png(file("d.png"));
    EXPECT_EQ(d.rgba[0], 0);
    EXPECT_EQ(d.rgba[4], 255);
    EXPECT_DOUBLE_EQ(
        measured(a, b, [](MeasureConfig& c) { c.threshold = 0.3; })["above"].get<double>(), 0);
}

TEST_F(MeasurePictures, ExrChannelsAreComparedAsTheyAre) {
    const std::vector<float> z{1, 2}, other{1, 2.5f}, nan{1, std::nanf("")};
    const auto exr = [&](const char* name, const std::vector<float>& plane, const char* channel) {
        write_exr(file(name), 2, 1,
                  std::vector<ExrChannel>{{channel, ChannelType::float32, plane, {}}});
        return file(name);
    };
    const std::string a = exr("a.exr", z, "Z");
    const json m = measured(a, exr("b.exr", other, "Z"), [](MeasureConfig&) {});
    EXPECT_DOUBLE_EQ(m["channels"]["Z"]["max"].get<double>(), 0.5);
    EXPECT_EQ(measured(a, exr("n.exr", nan, "Z"), [](MeasureConfig&) {})["not_finite"], 1);
    write_exr(file("two.exr"), 2, 1,
              std::vector<ExrChannel>{{"Z", ChannelType::float32, z, {}},
                                      {"k1", ChannelType::float32, z, {}}});
    for (const auto& [first, second] :
         {std::pair{a, file("two.exr")}, std::pair{file("two.exr"), a}})
        EXPECT_EQ(measured(first, second, [](MeasureConfig&) {})["identical"], false);
    EXPECT_EQ(measured(a, a, [](MeasureConfig&) {})["identical"], true);
    EXPECT_EQ(code_of([&] { measured(a, exr("c.exr", z, "k1"), [](MeasureConfig&) {}); }),
              ExitCode::bad_data);
}

/// A picture of more rows than two bands hold.
constexpr int kTall = 2000, kNarrow = 300;

TEST_F(MeasurePictures, TallPicturesAreComparedInBandsAsInOne) {
    constexpr std::size_t n = std::size_t{kTall} * kNarrow;
    std::vector<std::uint8_t> a(4 * n, 255), b;
    for (std::size_t i = 0; i < n; ++i) a[4 * i] = static_cast<std::uint8_t>(i % 251);
    b = a;
    b[4 * 7] ^= 3, b[4 * (n / 2) + 1] ^= 64, b[4 * (n - 1) + 2] ^= 64;  // in three bands
    write_png_srgb8(file("a.png"), kNarrow, kTall, a);
    write_png_srgb8(file("b.png"), kNarrow, kTall, b);
    const json m =
        measured(file("a.png"), file("b.png"), [&](MeasureConfig& c) { c.output = file("d.png"); });
    EXPECT_EQ(m["max_at"], json({0, 1000}));  // the first of the greatest
    EXPECT_DOUBLE_EQ(m["above"].get<double>(), 3.0 / n);
    EXPECT_NEAR(m["rms"].get<double>(), std::sqrt((9.0 + 2 * 64 * 64) / (4 * n)) / 255, 1e-12);
    EXPECT_DOUBLE_EQ(m["channels"]["B"]["above"].get<double>(), 1.0 / n);
    const PngImage d = read_png(file("d.png"));
    EXPECT_EQ(std::count_if(d.rgba.begin(), d.rgba.end(), [](int v) { return v > 0; }),
              std::ptrdiff_t{n + 9});
    EXPECT_EQ(d.rgba[4 * (n / 2)], 255);
    EXPECT_EQ(d.rgba[4 * 7], std::lround(255 * std::sqrt(3 / 64.0)));
}

TEST_F(MeasurePictures, TallExrOfEveryTypeAreComparedInBands) {
    constexpr std::size_t n = std::size_t{kTall} * kNarrow;
    std::vector<float> half_values(n, 0.5f), values(n);
    std::vector<std::uint32_t> ids(n);
    for (std::size_t i = 0; i < n; ++i)
        values[i] = static_cast<float>(i), ids[i] = static_cast<std::uint32_t>(i);
    const auto exr = [&](const char* name) {
        write_exr(file(name), kNarrow, kTall,
                  std::vector<ExrChannel>{{"R", ChannelType::half_float, half_values, {}},
                                          {"Z", ChannelType::float32, values, {}},
                                          {"surfel.id", ChannelType::uint32, {}, ids}});
        return file(name);
    };
    const std::string a = exr("a.exr");
    half_values[n / 2] = 0.25f, values[n - 1] += 3, ids[5] += 2;
    const json m = measured(a, exr("b.exr"), [](MeasureConfig&) {});
    EXPECT_DOUBLE_EQ(m["channels"]["R"]["max"].get<double>(), 0.25);
    EXPECT_DOUBLE_EQ(m["channels"]["Z"]["max"].get<double>(), 3);
    EXPECT_DOUBLE_EQ(m["channels"]["surfel.id"]["max"].get<double>(), 2);
    EXPECT_EQ(m["max_at"], json({kNarrow - 1, kTall - 1}));
    EXPECT_EQ(measured(a, a, [](MeasureConfig&) {})["identical"], true);
}

TEST_F(MeasurePictures, NoDifferenceIsSaidInWords) {
    const std::string a = png("a.png", {255, 0, 0, 255, 10, 20, 30, 255});
    const json m = measured(a, a, [&](MeasureConfig& c) { c.output = file("d.png"); });
    EXPECT_EQ(m["identical"], true);
    ASSERT_EQ(listener_.infos.size(), 1u);
    EXPECT_NE(listener_.infos[0].find("no difference between"), std::string::npos)
        << listener_.infos[0];
    EXPECT_NE(listener_.infos[0].find("d.png is black"), std::string::npos) << listener_.infos[0];
    EXPECT_NE(read_png(file("d.png")).metadata.at("ImageDescription").find("no difference"),
              std::string::npos);
    measured(a, png("b.png", {255, 0, 0, 255, 10, 21, 30, 255}), [](MeasureConfig&) {});
    EXPECT_EQ(listener_.infos.size(), 1u);
}

TEST_F(MeasurePictures, PicturesOfOtherSizesAndThingsThatAreNoneAreRefused) {
    const std::string a = png("a.png", {255, 0, 0, 255, 10, 20, 30, 255});
    write_png_srgb8(file("b.png"), 1, 1, std::vector<std::uint8_t>{1, 2, 3, 255});
    EXPECT_EQ(code_of([&] { measured(a, file("b.png"), [](MeasureConfig&) {}); }),
              ExitCode::bad_data);
    EXPECT_NE(message_.find("2x1"), std::string::npos) << message_;
    EXPECT_EQ(code_of([&] { measured(a, "m.slim", [](MeasureConfig&) {}); }), ExitCode::usage);
    EXPECT_EQ(code_of([&] { measured(a, a, [&](MeasureConfig& c) { c.output = a; }); }),
              ExitCode::usage);
    EXPECT_EQ(code_of([&] { measured(a, file("none.png"), [](MeasureConfig&) {}); }),
              ExitCode::bad_data);
}

}  // namespace
}  // namespace slim::test
