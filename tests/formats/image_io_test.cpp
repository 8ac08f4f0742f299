#include "formats/image_io.h"

#include "slim/base/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

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
    EXPECT_EQ(back.metadata.at("oiio:ColorSpace"), "sRGB");
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

TEST_F(ImageIo, UnwritablePlacesAndWrongFilesAreNamed) {
    const std::string nowhere = file("no/such/folder/a.png");
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
