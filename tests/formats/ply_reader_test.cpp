#include "tests/formats/format_support.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

namespace slim::test {
namespace {

template <class T>
std::string bytes_of(T value, bool big_endian) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (big_endian) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

const std::string kAscii =
    "ply\nformat ascii 1.0\ncomment small\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
    "1 2 3 0 0 1\n4.5 5 6 0 1 0\n-7e-1 8 9 1 0 0\n";

std::string binary_name(bool big) { return big ? "binary_big_endian" : "binary_little_endian"; }

/// Two vertices behind another element, properties in odd order and of odd types; with a list if
/// asked.
std::string binary_ply(bool big, bool list) {
    std::string text = "ply\nformat " + binary_name(big) +
                       " 1.0\nelement strip 2\nproperty list uchar short ids\n"
                       "element vertex 2\nproperty ushort scan\nproperty double z\n" +
                       (list ? "property list uint8 uint16 extra\n" : "") +
                       "property int8 y\nproperty float w\nproperty int x\nend_header\n";
    for (int row = 0; row < 2; ++row)
        text += bytes_of<std::uint8_t>(2, big) + bytes_of<std::int16_t>(0, big) +
                bytes_of<std::int16_t>(1, big);
    for (int v = 0; v < 2; ++v) {
        text += bytes_of<std::uint16_t>(static_cast<std::uint16_t>(300 + v), big);
        text += bytes_of<double>(1.25 + v, big);
        if (list) {
            text += bytes_of<std::uint8_t>(static_cast<std::uint8_t>(v), big);
            for (int k = 0; k < v; ++k) text += bytes_of<std::uint16_t>(9, big);
        }
        text += bytes_of<std::int8_t>(-5, big) + bytes_of<float>(-2.5f, big);
        text += bytes_of<std::int32_t>(70000 + v, big);
    }
    return text;
}

std::string binary_square(const std::string& faces, int n_faces) {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\n"
                       "property float y\nproperty float z\nelement face " +
                       std::to_string(n_faces) +
                       "\nproperty list uchar int vertex_indices\nend_header\n";
    const float corners[5][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {9, 9, 9}};
    for (const auto& corner : corners)
        for (const float value : corner) text += bytes_of(value, false);
    return text + faces;
}

std::string face(std::initializer_list<int> corners) {
    std::string text = bytes_of(static_cast<std::uint8_t>(corners.size()), false);
    for (const int corner : corners) text += bytes_of(corner, false);
    return text;
}

TEST(PlyReader, ReadsAsciiWithNormals) {
    const TempFolder folder;
    const PointChunk points = read_all(folder.write("a.ply", kAscii), 2);
    ASSERT_EQ(points.size(), 3u);
    EXPECT_EQ(points.position[1], (Vec3d{4.5, 5, 6}));
    EXPECT_EQ(points.position[2], (Vec3d{-0.7, 8, 9}));
    EXPECT_EQ(points.normal[2], (Vec3f{1, 0, 0}));
    EXPECT_TRUE(points.scan.empty());
}

TEST(PlyReader, ReadsBothByteOrdersWithAndWithoutListsInAnyChunks) {
    const TempFolder folder;
    for (const bool big : {false, true})
        for (const bool list : {false, true})
            for (const std::size_t chunk : {1u, 2u, 100u}) {
                SCOPED_TRACE(binary_name(big) + (list ? " list" : ""));
                const PointChunk points =
                    read_all(folder.write("b.ply", binary_ply(big, list)), chunk);
                ASSERT_EQ(points.size(), 2u);
                EXPECT_EQ(points.position[0], (Vec3d{70000, -5, 1.25}));
                EXPECT_EQ(points.position[1], (Vec3d{70001, -5, 2.25}));
                EXPECT_EQ(points.scan, (std::vector<std::uint16_t>{300, 301}));
                EXPECT_TRUE(points.normal.empty());
            }
}

TEST(PlyReader, SaysWhatIsCarriedAndWhatIsSkipped) {
    const TempFolder folder;
    const auto source = open_cloud(folder.write("b.ply", binary_ply(true, false)));
    const CloudInfo& info = source->info();
    EXPECT_EQ(info.format, "PLY binary big endian");
    EXPECT_EQ(info.n_points, 2u);
    EXPECT_EQ(info.carried, (std::vector<std::string>{"scan", "z", "y", "x"}));
    EXPECT_EQ(info.skipped, (std::vector<std::string>{"w"}));
    EXPECT_EQ(info.coordinates, CoordinateType::float64);
    EXPECT_TRUE(info.has_scan);
    EXPECT_FALSE(info.has_normals);
}

TEST(PlyReader, AddsTheOriginOfTheHeader) {
    const TempFolder folder;
    std::string text = kAscii;
    text.replace(text.find("small"), 5, "slim origin 403000.25 3604900.5 -1000");
    const std::string path = folder.write("o.ply", text);
    EXPECT_EQ(read_all(path).position[0], (Vec3d{403001.25, 3604902.5, -997}));
    EXPECT_EQ(open_cloud(path)->info().origin, (Vec3d{403000.25, 3604900.5, -1000}));
    text.replace(text.find("-1000"), 5, "nan  ");
    EXPECT_NE(reading_error(folder.write("n.ply", text)).find("line 3"), std::string::npos);
}

TEST(PlyReader, ReadsTheNoiseThatSmoothingTookOff) {
    const TempFolder folder;
    std::string text = kAscii;
    EXPECT_EQ(open_cloud(folder.write("none.ply", text))->info().noise_variance, 0);
    text.replace(text.find("small"), 5, "slim noise_variance 1.5e-8");
    EXPECT_EQ(open_cloud(folder.write("v.ply", text))->info().noise_variance, 1.5e-8);
    for (const char* bad : {"-1e-8 ", "inf   ", "nan   ", "      ", "much  "}) {
        SCOPED_TRACE(bad);
        std::string other = text;
        other.replace(other.find("1.5e-8"), 6, bad);
        EXPECT_NE(reading_error(folder.write("bad.ply", other)).find("line 3"), std::string::npos);
    }
}

TEST(PlyReader, TakesCrLfCrTabsBlanksAndEmptyLines) {
    const TempFolder folder;
    const PointChunk expected = read_all(folder.write("a.ply", kAscii));
    for (const char* end : {"\r\n", "\r", "\n\n", " \t\n  "}) {
        std::string text;
        for (const char c : kAscii)
            if (c == '\n') text += end;
            else text += c == ' ' ? std::string("\t ") : std::string(1, c);
        const PointChunk points = read_all(folder.write("e.ply", text));
        EXPECT_EQ(points.position, expected.position);
        EXPECT_EQ(points.normal, expected.normal);
    }
}

TEST(PlyReader, BinaryDataMayBeginWithALineEnd) {
    const TempFolder folder;
    for (const char* end : {"\n", "\r\n"}) {
        std::string text;
        for (const std::string line : {"ply", "format binary_little_endian 1.0", "element vertex 1",
                                       "property uchar x", "property uchar y", "property uchar z",
                                       "end_header"})
            text += line + end;
        const PointChunk points = read_all(folder.write("l.ply", text + "\n\r\n"));
        ASSERT_EQ(points.size(), 1u);
        EXPECT_EQ(points.position[0], (Vec3d{10, 13, 10}));
    }
}

TEST(PlyReader, KeepsNonFinitePointsForTheCaller) {
    const TempFolder folder;
    std::string text = kAscii;
    text.replace(text.find("1 2 3"), 5, "nan +inf 1e999");
    const PointChunk points = read_all(folder.write("n.ply", text));
    ASSERT_EQ(points.size(), 3u);
    EXPECT_TRUE(std::isnan(points.position[0].x));
    EXPECT_TRUE(std::isinf(points.position[0].y));
    EXPECT_TRUE(std::isinf(points.position[0].z));
}

/// Every cut of a small file is an error that names the file, or (only the last line end or nothing
/// that is read missing) all the points.
void expect_no_silent_truncation(const TempFolder& folder, const std::string& whole) {
    const PointChunk all = read_all(folder.write("whole.ply", whole));
    for (std::size_t n = 0; n < whole.size(); ++n) {
        SCOPED_TRACE(n);
        const std::string path = folder.write("cut.ply", whole.substr(0, n));
        const std::string error = reading_error(path);
        if (!error.empty()) {
            EXPECT_NE(error.find(path), std::string::npos) << error;
            continue;
        }
        ASSERT_GE(n + 1, whole.size());
        EXPECT_EQ(read_all(path).size(), all.size());
    }
}

TEST(PlyReader, RefusesEveryTruncation) {
    const TempFolder folder;
    // The last value is one digit long, so that no cut leaves another number.
    expect_no_silent_truncation(folder, kAscii);
    for (const bool big : {false, true}) {
        expect_no_silent_truncation(folder, binary_ply(big, false));
        expect_no_silent_truncation(folder, binary_ply(big, true));
    }
    expect_no_silent_truncation(folder, binary_square(face({0, 1, 2, 3}), 1));
}

TEST(PlyReader, RefusesCountsThatLieBeforeAllocating) {
    const TempFolder folder;
    for (const char* count : {"4000000000", "18446744073709551615", "4"}) {
        for (std::string text : {kAscii, binary_ply(false, false)}) {
            const auto at = text.find("element vertex ") + 15;
            text.replace(at, 1, count);
            const std::string error = reading_error(folder.write("c.ply", text));
            EXPECT_NE(error.find(count), std::string::npos) << error;
        }
    }
    std::string faces = binary_square(face({0, 1, 2}), 1);
    faces.replace(faces.find("face 1") + 5, 1, "3999999999");
    EXPECT_NE(reading_error(folder.write("f.ply", faces)).find("3999999999"), std::string::npos);
}

TEST(PlyReader, NamesTheMissingPropertyTheBadWordAndTheRow) {
    const TempFolder folder;
    const auto error_of = [&](const std::string& from, const std::string& to) {
        std::string text = kAscii;
        text.replace(text.find(from), from.size(), to);
        return reading_error(folder.write("m.ply", text));
    };
    EXPECT_NE(error_of("float z\n", "float q\n").find("no scalar property z"), std::string::npos);
    EXPECT_NE(error_of("4.5 5 6", "4.5 x5 6").find("line 13"), std::string::npos);
    EXPECT_NE(error_of("4.5 5 6", "4.5 x5 6").find("'x5'"), std::string::npos);
    EXPECT_NE(error_of("4.5 5 6", "4.5 5").find("the row ends where property nz"),
              std::string::npos);
    EXPECT_NE(error_of("4.5 5 6", "4.5 5 6 7").find("more values"), std::string::npos);
    EXPECT_NE(error_of("float z\n", "flaot z\n").find("'flaot'"), std::string::npos);
    EXPECT_NE(error_of("vertex 3", "vertex -3").find("'-3'"), std::string::npos);
    EXPECT_NE(error_of("float y", "float x").find("twice"), std::string::npos);
    EXPECT_NE(error_of("ascii 1.0", "ascii 2.0").find("'2.0'"), std::string::npos);
    EXPECT_NE(error_of("element vertex", "element edge").find("found edge"), std::string::npos);
    EXPECT_NE(error_of("float nx", "list uchar int nx").find("row ends"), std::string::npos);
}

TEST(PlyReader, MakesAreaWeightedNormalsFromFaces) {
    const TempFolder folder;
    // A square of area 4 facing +z, and a triangle of area 2 facing -y, sharing corners 0 and 1.
    std::string text = binary_square(face({0, 1, 2, 3}) + face({0, 1, 4}), 2);
    const std::string path = folder.write("s.ply", text);
    EXPECT_TRUE(open_cloud(path)->info().normals_from_faces);
    const PointChunk points = read_all(path, 2);
    ASSERT_EQ(points.normal.size(), 5u);
    EXPECT_EQ(points.normal[2], (Vec3f{0, 0, 1}));
    // (0,0,8) + cross((2,0,0), (9,9,9)) = (0,-18,18): sum (0,-18,26).
    const float len = std::hypot(18.0f, 26.0f);
    EXPECT_NEAR(points.normal[0].y, -18.0f / len, 1e-6);
    EXPECT_NEAR(points.normal[0].z, 26.0f / len, 1e-6);
}

TEST(PlyReader, AClosedMeshWoundInwardsIsTurned) {
    const TempFolder folder;
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\n"
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        "100 0 0\n101 0 0\n100 1 0\n100 0 1\n";
    const std::string outwards =
        folder.write("o.ply", head + "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const std::string inwards =
        folder.write("i.ply", head + "3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n");
    EXPECT_FALSE(open_cloud(outwards)->info().faces_turned);
    EXPECT_TRUE(open_cloud(inwards)->info().faces_turned);
    EXPECT_EQ(read_all(inwards).normal, read_all(outwards).normal);
    EXPECT_LT(read_all(inwards).normal[0].x, 0);
    // Two sides of it enclose nothing for sure and stay as they are.
    std::string open = head + "3 0 1 2\n3 0 3 1\n";
    open.replace(open.find("face 4"), 6, "face 2");
    EXPECT_FALSE(open_cloud(folder.write("p.ply", open))->info().faces_turned);
}

TEST(PlyReader, UnusedVerticesHaveNoNormalAndBadIndicesAreNamed) {
    const TempFolder folder;
    const PointChunk points = read_all(folder.write("u.ply", binary_square(face({0, 1, 2, 3}), 1)));
    EXPECT_EQ(points.normal[4], (Vec3f{0, 0, 0}));
    for (const int bad : {5, -1}) {
        const std::string error = reading_error(
            folder.write("i.ply", binary_square(face({0, 1, 2}) + face({0, bad, 2}), 2)));
        EXPECT_NE(error.find("face 2 has vertex index " + std::to_string(bad)), std::string::npos)
            << error;
    }
}

TEST(PlyReader, RefusesAnEmptyFileAHeaderAloneAndAMissingFile) {
    const TempFolder folder;
    EXPECT_NE(reading_error(folder.write("e.ply", "")).find("empty"), std::string::npos);
    EXPECT_NE(reading_error(folder.write("h.ply", "ply\nformat ascii 1.0\nend_header\n"))
                  .find("no element"),
              std::string::npos);
    EXPECT_NE(reading_error(folder.write("x.ply", "plywood")).find("PLY header"),
              std::string::npos);
    EXPECT_NE(reading_error(folder.file("missing.ply")).find("cannot be opened"),
              std::string::npos);
    EXPECT_NE(reading_error(folder.file("")).find("is a folder"), std::string::npos);
}

}  // namespace
}  // namespace slim::test
