#include "formats/image_io.h"

#include "slim/base/error.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <png.h>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// A folder of this test's own, removed afterwards.
class ImageIo : public testing::Test {
protected:
    ImageIo() {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() /
                  ("slim_image_io_" + std::string(test->name()) + std::to_string(getpid()));
        fs::create_directories(folder_);
    }
    ~ImageIo() override { fs::remove_all(folder_); }
    std::string file(const char* name) const { return (folder_ / name).string(); }

    fs::path folder_;
};

std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::uint8_t> ramp(int width, int height, bool opaque) {
    std::vector<std::uint8_t> rgba;
    for (int i = 0; i < width * height; ++i)
        for (int c = 0; c < 4; ++c)
            rgba.push_back(c == 3 && opaque ? std::uint8_t{255}
                                            : static_cast<std::uint8_t>(i * 7 + c * 31));
    return rgba;
}

TEST_F(ImageIo, PngKeepsEveryByteAndStraightAlpha) {
    const auto rgba = ramp(7, 5, false);
    write_png_srgb8(file("a.png"), 7, 5, rgba, {{"Software", "slim test"}});
    const PngImage back = read_png(file("a.png"));
    EXPECT_EQ(back.width, 7);
    EXPECT_EQ(back.height, 5);
    EXPECT_EQ(back.n_file_channels, 4);
    EXPECT_EQ(back.rgba, rgba);
    EXPECT_EQ(back.metadata.at("Software"), "slim test");
    EXPECT_TRUE(back.is_srgb);
    EXPECT_EQ(back.metadata.size(), 1u);
}

TEST_F(ImageIo, OpaquePngHasThreeChannels) {
    const auto rgba = ramp(4, 3, true);
    write_png_srgb8(file("a.png"), 4, 3, rgba);
    EXPECT_EQ(read_png(file("a.png")).n_file_channels, 3);
    EXPECT_EQ(read_png(file("a.png")).rgba, rgba);
}

TEST_F(ImageIo, ExrKeepsNamesTypesValuesAndText) {
    const std::vector<float> red{0, 0.25f, 1, 2, 0.1f, 65504}, z{1.1f, -2.2f, 3e30f, 0, 5, 6};
    const std::vector<std::uint32_t> id{0, 1, 16777217, 4294967295u, 5, 6};
    const std::vector<ExrChannel> channels{{"R", ChannelType::half_float, red, {}},
                                           {"Z", ChannelType::float32, z, {}},
                                           {"curvature.mean", ChannelType::float32, red, {}},
                                           {"surfel.id", ChannelType::uint32, {}, id}};
    const std::array<float, 16> m{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    write_exr(file("a.exr"), 3, 2, channels,
              {{"slim:origin", "403000.12345678901 1 2"}, {"DateTime", "2005:07:31 10:00:00"}},
              {{"worldToCamera", m}});
    const ExrImage back = read_exr(file("a.exr"));
    EXPECT_EQ(back.width, 3);
    EXPECT_EQ(back.height, 2);
    ASSERT_EQ(back.channels.size(), 4u);
    EXPECT_EQ(back.channels.at("R").type, ChannelType::half_float);
    EXPECT_FLOAT_EQ(back.channels.at("R").floats[5], 65504);
    EXPECT_NEAR(back.channels.at("R").floats[4], 0.1f, 1e-4);  // half: 11 bits
    EXPECT_EQ(back.channels.at("Z").type, ChannelType::float32);
    EXPECT_EQ(back.channels.at("Z").floats, z);
    EXPECT_EQ(back.channels.at("curvature.mean").floats, red);
    EXPECT_EQ(back.channels.at("surfel.id").type, ChannelType::uint32);
    EXPECT_EQ(back.channels.at("surfel.id").integers, id);
    EXPECT_EQ(back.metadata.at("slim:origin"), "403000.12345678901 1 2");
    EXPECT_EQ(back.metadata.at("capDate"), "2005:07:31 10:00:00");
    EXPECT_EQ(back.matrices.at("worldToCamera"), m);
    EXPECT_TRUE(back.has_chromaticities);
    EXPECT_TRUE(back.zip);
}

TEST_F(ImageIo, HalvesAreHeldAtTheirLargest) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> red{65504, 65519, 65520, -1e6f, inf, -inf}, z{1e6f, inf, 0, 0, 0, 0};
    const std::vector<ExrChannel> channels{{"R", ChannelType::half_float, red, {}},
                                           {"Z", ChannelType::float32, z, {}}};
    ExrWriter writer(file("a.exr"), 3, 2, channels);
    writer.add_rows(2, channels);
    EXPECT_EQ(writer.n_clamped(), 5u);
    writer.commit();
    const ExrImage back = read_exr(file("a.exr"));
    EXPECT_EQ(back.channels.at("R").floats,
              (std::vector<float>{65504, 65504, 65504, -65504, 65504, -65504}));
    EXPECT_EQ(back.channels.at("Z").floats, z);  // floats are as they are
}

TEST_F(ImageIo, SamePicturesAreSameBytesAndBringNoClock) {
    const auto rgba = ramp(9, 9, false);
    const std::vector<float> z(81, 1.5f);
    const ExrChannel channel{"Z", ChannelType::float32, z, {}};
    write_png_srgb8(file("a.png"), 9, 9, rgba);
    write_exr(file("a.exr"), 9, 9, {&channel, 1});
    EXPECT_FALSE(read_png(file("a.png")).metadata.contains("DateTime"));
    EXPECT_FALSE(read_exr(file("a.exr")).metadata.contains("capDate"));
    write_png_srgb8(file("b.png"), 9, 9, rgba);
    write_exr(file("b.exr"), 9, 9, {&channel, 1});
    EXPECT_EQ(bytes_of(file("a.png")), bytes_of(file("b.png")));
    EXPECT_EQ(bytes_of(file("a.exr")), bytes_of(file("b.exr")));
}

TEST_F(ImageIo, NothingIsLeftBesideTheFiles) {
    write_png_srgb8(file("a.png"), 2, 2, ramp(2, 2, true));
    write_png_srgb8(file("a.png"), 2, 2, ramp(2, 2, false));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(ImageIo, TextsOfAPngAreOtherProgramsNamesAndAnyAlphabet) {
    const ImageMetadata words{{"DateTime", "2005:07:31 10:00:00"},
                              {"ImageDescription", "a b"},
                              {"slim:config", "input = \"Büste/Ναός.ply\""}};
    write_png_srgb8(file("a.png"), 3, 2, ramp(3, 2, true), words);
    const std::string bytes = bytes_of(file("a.png"));
    EXPECT_NE(bytes.find("tEXtDescription"), std::string::npos);
    EXPECT_NE(bytes.find("iTXtslim:config"), std::string::npos);  // tEXt is Latin-1
    const ImageMetadata back = read_png(file("a.png")).metadata;
    for (const auto& [name, value] : words) EXPECT_EQ(back.at(name), value);
}

/// A PNG of 8 x 8 pixels of another program: 16 bits of grey and alpha, in seven passes.
std::string deep_interlaced_png(const std::string& path) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    std::FILE* out = std::fopen(path.c_str(), "wb");
    png_init_io(png, out);
    png_set_IHDR(png, info, 8, 8, 16, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_INTERLACE_ADAM7,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    std::array<std::array<png_byte, 32>, 8> pixels{};
    std::array<png_bytep, 8> rows{};
    for (std::size_t y = 0; y < 8; ++y) {
        rows[y] = pixels[y].data();
        for (std::size_t x = 0; x < 8; ++x)
            pixels[y][4 * x] = static_cast<png_byte>(8 * y + x),
                          pixels[y][4 * x + 2] = pixels[y][4 * x + 3] = 200;
    }
    png_write_image(png, rows.data());
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    std::fclose(out);
    return path;
}

TEST_F(ImageIo, PngsOfOtherProgramsAreReadAsRgba) {
    PngReader reader(deep_interlaced_png(file("a.png")));
    EXPECT_EQ(reader.header().n_file_channels, 2);
    std::vector<std::uint8_t> rgba;
    reader.read_rows(3, rgba);
    reader.read_rows(5, rgba);  // rows 3 to 7
    ASSERT_EQ(rgba.size(), 4u * 8 * 5);
    EXPECT_EQ((std::vector<std::uint8_t>(rgba.begin() + 4, rgba.begin() + 8)),
              (std::vector<std::uint8_t>{25, 25, 25, 200}));
}

TEST_F(ImageIo, DamagedPngsAreRefused) {
    write_png_srgb8(file("a.png"), 50, 50, ramp(50, 50, false));
    const std::string whole = bytes_of(file("a.png"));
    for (const std::size_t n :
         {std::size_t{20}, std::size_t{60}, whole.size() / 2, whole.size() - 30}) {
        std::ofstream(file("cut.png"), std::ios::binary) << whole.substr(0, n);
        EXPECT_THROW(read_png(file("cut.png")), FormatError) << n;
    }
    std::string flipped = whole;
    flipped[whole.size() / 2] ^= 1;
    std::ofstream(file("flipped.png"), std::ios::binary) << flipped;
    EXPECT_THROW(read_png(file("flipped.png")), FormatError);
}

TEST_F(ImageIo, LightIsLinearFromIntegersAndAsItIsFromFloats) {
    const std::vector<std::uint8_t> grey{188, 188, 188, 255};
    write_png_srgb8(file("a.png"), 1, 1, grey);
    EXPECT_NEAR(read_light_image(file("a.png")).rgb.at(0), 0.5, 0.005);
    const std::vector<float> bright{7.5f};
    const std::vector<ExrChannel> rgb{{"R", ChannelType::float32, bright, {}},
                                      {"G", ChannelType::float32, bright, {}},
                                      {"B", ChannelType::float32, bright, {}}};
    write_exr(file("a.exr"), 1, 1, rgb);
    EXPECT_FLOAT_EQ(read_light_image(file("a.exr")).rgb.at(2), 7.5f);
    std::ofstream(file("text.hdr")) << "no picture";
    EXPECT_THROW(read_light_image(file("text.hdr")), FormatError);
    EXPECT_THROW(read_light_image(file("absent.hdr")), IoError);
}

TEST_F(ImageIo, UnwritablePlacesAndWrongFilesAreNamed) {
    std::ofstream(file("text")) << "no folder";
    const std::string nowhere = file("text/folder/a.png");
    try {
        write_png_srgb8(nowhere, 2, 2, ramp(2, 2, true));
        FAIL();
    } catch (const IoError& e) {
        EXPECT_NE(std::string(e.what()).find(nowhere), std::string::npos);
    }
    std::ofstream(file("text.exr")) << "this is no picture";
    std::ofstream(file("text.png")) << "this is no picture";
    EXPECT_THROW(read_exr(file("text.exr")), FormatError);
    EXPECT_THROW(read_png(file("text.png")), FormatError);
    EXPECT_THROW(read_png(file("absent.png")), IoError);
    EXPECT_THROW(read_exr(file("absent.exr")), IoError);
}

}  // namespace
}  // namespace slim
