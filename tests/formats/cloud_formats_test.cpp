#include "tests/formats/format_support.h"

#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

std::string packed(const std::string& bytes) {
    std::string out(bytes.size() + 1000, '\0');
    z_stream z{};
    EXPECT_EQ(deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    z.avail_in = static_cast<uInt>(bytes.size());
    z.next_out = reinterpret_cast<Bytef*>(out.data());
    z.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&z, Z_FINISH), Z_STREAM_END);
    out.resize(out.size() - z.avail_out);
    deflateEnd(&z);
    return out;
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

TEST(XyzReader, ReadsThreeColumnsWithAnySeparatorsAndComments) {
    const TempFolder folder;
    for (const char* text :
         {"1 2 3\n-4 5e1 .5\n", "# a comment\n1,2,3\r\n\r\n-4,50,0.5\r\n",
          "// X and Y\n1;2;3\n  -4\t+50 ; 0.5", "x,y,z\n1, 2, 3\n-4, 50, 0.5\n"}) {
        const PointChunk points = read_all(folder.write("a.xyz", text), 1);
        ASSERT_EQ(points.size(), 2u) << text;
        EXPECT_EQ(points.position[0], (Vec3d{1, 2, 3}));
        EXPECT_EQ(points.position[1], (Vec3d{-4, 50, 0.5}));
        EXPECT_FALSE(!points.normal.empty());
    }
}

TEST(XyzReader, TellsNormalsFromColoursAndIntensity) {
    const TempFolder folder;
    const auto has_normals = [&](const std::string& text) {
        return open_cloud(folder.write("n.txt", text))->info().has_normals;
    };
    EXPECT_TRUE(has_normals("1 2 3 0 0 1\n1 2 4 0.6 0.8 0\n"));
    EXPECT_TRUE(has_normals("1 2 3 0 0 1\n1 2 4 0.6 0.8 0\n1 2 5 0 0 0\n"));
    EXPECT_FALSE(has_normals("1 2 3 255 0 1\n1 2 4 12 12 0\n"));
    EXPECT_FALSE(has_normals("1 2 3 0 0 1\n1 2 4 12 12 0\n"));
    EXPECT_FALSE(has_normals("1 2 3 0 0 0\n1 2 4 0 0 0\n"));
    EXPECT_FALSE(has_normals("1 2 3 -1613 52 70 64\n"));
    EXPECT_TRUE(has_normals("1 2 3 200 100 50 0 0 1\n1 2 3 200 100 50 0 1 0\n"));
    const PointChunk points =
        read_all(folder.write("m.txt", "1 2 3 9 8 7 0 0 1\n1 2 3 4 5 6 0 1 0\n"));
    EXPECT_EQ(points.normal[1], (Vec3f{0, 1, 0}));
}

TEST(XyzReader, FollowsALineOfNames) {
    const TempFolder folder;
    for (const char* names :
         {"nx;ny;nz;Z;Y;X;scan", "//nx ny nz z y x scan", "\"NX\",\"NY\",\"NZ\",z,y,x,scan"}) {
        const PointChunk points =
            read_all(folder.write("n.csv", std::string(names) + "\n0,0,1,3,2,1,7\n"));
        ASSERT_EQ(points.size(), 1u) << names;
        EXPECT_EQ(points.position[0], (Vec3d{1, 2, 3}));
        EXPECT_EQ(points.normal[0], (Vec3f{0, 0, 1}));
        EXPECT_EQ(points.scan[0], 7);
    }
}

TEST(XyzReader, NamesTheColumnsThatItPassesOver) {
    TempFolder folder;
    const auto skipped = [&](const std::string& text) {
        folder.write("n.xyz", text);
        return open_cloud(folder.file("n.xyz"))->info().skipped;
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(skipped("// Intensity x y z nx ny scan R\n7 1 2 3 0 1 5 9\n"),
              (Names{"intensity", "nx", "ny", "r"}));
    EXPECT_EQ(skipped("x,y,z\n1,2,3\n"), Names{});
    EXPECT_EQ(skipped("1 2 3 4 5\n"), (Names{"unnamed 1", "unnamed 2"}));
}

TEST(XyzReader, HoldsAPtsCountAgainstTheRows) {
    const TempFolder folder;
    EXPECT_EQ(read_all(folder.write("a.pts", "2\n1 2 3\n4 5 6\n")).size(), 2u);
    EXPECT_EQ(read_all(folder.write("b.pts", "2\n1 2 3\n4 5 6\n1\n7 8 9\n")).size(), 3u);
    EXPECT_NE(reading_error(folder.write("c.pts", "3\n1 2 3\n4 5 6\n")).find("2 of 3 declared"),
              std::string::npos);
    EXPECT_EQ(read_all(folder.write("d.pts", "1\n1 2 3\n4 5 6\n")).size(), 2u);
    EXPECT_NE(reading_error(folder.write("e.txt", "20\n30\n0 0 0\n")).find("PTX"),
              std::string::npos);
}

TEST(XyzReader, PassesOverAByteOrderMarkAtItsStart) {
    const TempFolder folder;
    const std::string mark = "\xef\xbb\xbf";
    const auto read = [&](const std::string& name, const std::string& text) {
        return read_all(folder.write(name, text));
    };
    const auto error = [&](const std::string& name, const std::string& text) {
        return reading_error(folder.write(name, text));
    };
    EXPECT_EQ(read("a.xyz", mark + "0.618 2 3\n4 5 6\n").position.at(0), (Vec3d{0.618, 2, 3}));
    EXPECT_EQ(read("b.xyz.gz", packed(mark + "7 8 9\n")).position.at(0), (Vec3d{7, 8, 9}));
    // Names of columns in another order, a comment of them, and a count hold with it as without.
    EXPECT_EQ(read("c.csv", mark + "z,y,x\r\n1,2,3\r\n").position.at(0), (Vec3d{3, 2, 1}));
    EXPECT_EQ(read("d.txt", mark + "# z y x\n1 2 3\n").position.at(0), (Vec3d{3, 2, 1}));
    EXPECT_EQ(read("e.pts", mark + "2\n1 2 3\n4 5 6\n").size(), 2u);
    EXPECT_NE(error("f.pts", mark + "3\n1 2 3\n4 5 6\n").find("2 of 3 declared"),
              std::string::npos);
    // One at its start; elsewhere, or half of it, it is no number.
    EXPECT_NE(error("g.xyz", mark + mark + "1 2 3\n").find("line 1: column 1"), std::string::npos);
    EXPECT_NE(error("h.xyz", "1 2 3\n" + mark + "4 5 6\n").find("line 2: column 1"),
              std::string::npos);
    EXPECT_NE(error("i.xyz", mark.substr(0, 2) + "1 2 3\n").find("line 1: column 1"),
              std::string::npos);
    EXPECT_EQ(read("j.xyz", mark).size(), read("k.xyz", "\n").size());
}

TEST(XyzReader, RefusesDecimalCommasByName) {
    const TempFolder folder;
    for (const char* text :
         {"1,5 2,0 3,1\n", "1,5;2,0;3,1\n", "1;2;3,5\n", "x y z\n-1,5\t2\t3,1e1\n"}) {
        const std::string error = reading_error(folder.write("comma.xyz", text));
        EXPECT_NE(error.find("decimal commas"), std::string::npos) << text << ": " << error;
        EXPECT_NE(error.find("sed 's/,/./g' " + folder.file("comma.xyz")), std::string::npos)
            << error;
    }
    for (const char* text : {"1,2,3\n", "1, 2, 3\n", "1.5,2,3\n", "1,2,3 0,0,1\n", "1.5;2;3\n"})
        EXPECT_EQ(read_all(folder.write("a.xyz", text), 1).size(), 1u) << text;
}

TEST(XyzReader, SaysWhichNamesItKnowsWhereALineHasOthers) {
    const TempFolder folder;
    for (const char* names : {"easting,northing,elevation\n", "\"E\";\"N\";\"H\"\n"}) {
        const std::string error =
            reading_error(folder.write("a.csv", names + std::string("1,2,3\n2,3,4\n")));
        for (const char* part : {"line 1", "x, y and z", "nx ny nz", "scan"})
            EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
        EXPECT_NE(error.find(std::string(names).substr(0, 3)), std::string::npos) << error;
    }
    // In the midst of numbers a word is none of a header.
    const std::string later = reading_error(folder.write("b.csv", "1,2,3\na,b,c\n"));
    EXPECT_NE(later.find("line 2: column 1: expected a number, found 'a'"), std::string::npos)
        << later;
}

TEST(CloudKind, NamesTheFilesInTheCommandThatConverts) {
    const TempFolder folder;
    const std::string error = reading_error(folder.write("hill.laz", "LASF and more"));
    EXPECT_NE(error.find("pdal translate " + folder.file("hill.laz") + " " +
                         folder.file("hill.ply") + " "),
              std::string::npos)
        << error;
}

TEST(XyzReader, NamesTheLine) {
    const TempFolder folder;
    EXPECT_NE(reading_error(folder.write("a.xyz", "1 2 3\n# c\n1 2\n")).find("line 3"),
              std::string::npos);
    EXPECT_NE(reading_error(folder.write("b.xyz", "1 2 3\n1 2 3,4x\n")).find("line 2: column 4"),
              std::string::npos);
    EXPECT_NE(reading_error(folder.write("c.xyz", "1 2\n")).find("at least 3 columns"),
              std::string::npos);
    EXPECT_NE(reading_error(folder.write("d.xyz", "v 1 2 3\n")).find("'v'"), std::string::npos);
    std::string many;
    for (int i = 0; i < 150; ++i) many += "1 2 3\n";
    EXPECT_NE(reading_error(folder.write("e.xyz", many + "1 2 3 4\n")).find("line 151"),
              std::string::npos);
}

TEST(Gzip, UnpacksInAStreamAndRefusesEveryTruncation) {
    const TempFolder folder;
    std::string text;
    for (int i = 0; i < 200000; ++i) text += std::to_string(i) + " 2 3\n";
    const std::string whole = packed(text);
    const PointChunk points = read_all(folder.write("a.xyz.gz", whole), 100000);
    ASSERT_EQ(points.size(), 200000u);
    EXPECT_EQ(points.position.back(), (Vec3d{199999, 2, 3}));
    EXPECT_EQ(read_all(folder.write("b.xyz.gz", packed("1 2 3\n") + packed("4 5 6\n"))).size(), 2u);
    EXPECT_NE(reading_error(folder.write("c.xyz.gz", whole.substr(0, whole.size() / 2))), "");
    const std::string small = packed("1 2 3\n4 5 6\n");
    for (std::size_t n = 0; n < small.size(); ++n)
        EXPECT_NE(reading_error(folder.write("d.xyz.gz", small.substr(0, n))), "") << n;
    std::string damaged = small;
    damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);
    EXPECT_NE(reading_error(folder.write("e.xyz.gz", damaged)).find("gzip"), std::string::npos);
}

TEST(Gzip, ALyingCountEndsInAnErrorNotInMemory) {
    const TempFolder folder;
    const std::string text =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n123456789012";
    EXPECT_NE(reading_error(folder.write("l.ply.gz", packed(text))).find("1 of 4000000000"),
              std::string::npos);
}

TEST(CloudKind, RefusesBinariesByTheirFirstBytes) {
    const TempFolder folder;
    for (const std::string magic : {"LASF\1\2", "ASTM-E57", "DRACO", "\x89PNG\r\n", "OFF\n3 1 0\n",
                                    "# .PCD v0.7\n", "SLIMTREE", "II*", "solid x\n"}) {
        const std::string error =
            reading_error(folder.write("name.xyz", magic + std::string(9, '\0')));
        EXPECT_NE(error.find("read are PLY"), std::string::npos) << magic << error;
    }
    EXPECT_NE(reading_error(folder.write("b.bin", std::string("12 3\0 4", 7))).find("byte 4"),
              std::string::npos);
}

TEST(SharedClouds, EveryPlyOfTheSampleFormatsIsReadOrRefusedWithAReason) {
    const fs::path data = shared_data();
    if (data.empty()) GTEST_SKIP() << "the shared test data is not there";
    // These declare no x, y or z (or only two of them).
    const std::set<std::string> refused{"all_atomic_types_ok_ascii.ply",
                                        "exponent_values_ok_ascii.ply",
                                        "leading_spaces_ok_ascii.ply", "sized_dims.ply"};
    int n_read = 0;
    for (const fs::path& file : files_in(data / "formats")) {
        if (file.extension() != ".ply") continue;
        SCOPED_TRACE(file.filename());
        const std::string error = reading_error(file);
        if (refused.count(file.filename())) {
            EXPECT_NE(error.find("has no scalar property"), std::string::npos) << error;
            continue;
        }
        EXPECT_EQ(error, "");
        EXPECT_EQ(read_all(file, 1000).size(), open_cloud(file)->info().n_points);
        EXPECT_GT(read_all(file, 1000).size(), 0u);
        ++n_read;
    }
    EXPECT_GE(n_read, 20);
}

TEST(SharedClouds, MalformedPlysNeverGivePointsTheyDoNotHave) {
    const fs::path data = shared_data();
    if (data.empty()) GTEST_SKIP() << "the shared test data is not there";
    const std::set<std::string> without_points{"ply_empty_bin.ply", "zero_vertices.ply"};
    for (const fs::path& file : files_in(data / "malformed")) {
        if (file.extension() != ".ply") continue;
        SCOPED_TRACE(file.filename());
        if (without_points.count(file.filename())) EXPECT_EQ(read_all(file).size(), 0u);
        else EXPECT_NE(reading_error(file).find(file.string()), std::string::npos);
    }
}

TEST(SharedClouds, OtherFormatsAreRefusedNamingThoseThatAreRead) {
    const fs::path data = shared_data();
    if (data.empty()) GTEST_SKIP() << "the shared test data is not there";
    const std::set<std::string> read{".ply", ".xyz", ".conf"};
    int n_refused = 0;
    for (const char* folder : {"formats", "malformed"})
        for (const fs::path& file : files_in(data / folder)) {
            if (read.count(file.extension())) continue;
            if (file.extension() == ".pts" && file.filename() != "bunny16k.pts") continue;
            SCOPED_TRACE(file.filename());
            EXPECT_NE(reading_error(file).find("read are PLY"), std::string::npos)
                << reading_error(file);
            ++n_refused;
        }
    EXPECT_GE(n_refused, 60);
}

TEST(SharedClouds, TextCloudsAreRead) {
    const fs::path data = shared_data();
    if (data.empty()) GTEST_SKIP() << "the shared test data is not there";
    for (const char* name : {"bunny_part1.xyz", "multisensor_lidar.xyz", "points_agisoft.xyz",
                             "points_cloudcompare.xyz", "autzen.pts", "bunny_8.pts", "test.pts"}) {
        SCOPED_TRACE(name);
        const fs::path file = data / "formats" / name;
        EXPECT_EQ(reading_error(file), "");
        EXPECT_GE(read_all(file, 1000).size(), 8u);
        EXPECT_FALSE(open_cloud(file)->info().has_normals);
    }
}

}  // namespace
}  // namespace slim::test
