#include "formats/cloud_rewriter.h"

#include "formats/point_source.h"
#include "tests/formats/format_support.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace slim::test {
namespace {

class CloudRewriterTest : public testing::Test {
protected:
    /// Rewrites a file of these bytes; every odd point moves by (0.25, 0, 0) and gets the normal z.
    std::string rewritten(const std::string& name, const std::string& bytes,
                          double text_step = 1e-3, std::size_t at_once = 2) {
        const std::string in = folder_.write("in_" + name, bytes), out = folder_.file(name);
        const PointChunk points = read_all(in);
        const auto rewriter = rewrite_cloud(in, out, text_step);
        std::vector<RewrittenPoint> some;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const bool moves = i % 2 == 1;
            const Vec3d p = points.position[i] + Vec3d{moves ? 0.25 : 0, 0, 0};
            some.push_back({p, {0, 0, moves ? 1.0f : 0}, moves ? 0.25f : 0, moves});
            if (some.size() < at_once && i + 1 < points.size()) continue;
            rewriter->write(some);
            some.clear();
        }
        rewriter->commit();
        return read_bytes(out);
    }
    TempFolder folder_;
};

template <class T>
std::string raw(T value, bool big = false) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof(T));
    return big ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

TEST_F(CloudRewriterTest, SaysTheMostOfTheNoiseOnceInAPlyAndNothingInText) {
    const std::string rest = "element vertex 1\nproperty float x\nproperty float y\nproperty float "
                             "z\nend_header\n1 2 3\n";
    const auto lines_of = [&](const std::string& said, double noise, const char* name = "n.ply") {
        const std::string head = "ply\nformat ascii 1.0\n" + said;
        const std::string in =
            folder_.write(std::string("in_") + name,
                          std::string(name).ends_with("ply") ? head + rest : "1 2 3\n");
        const auto rewriter = rewrite_cloud(in, folder_.file(name), 1e-3, noise);
        rewriter->write(std::vector<RewrittenPoint>{{{1, 2, 3}, {0, 0, 1}, 0, false}});
        rewriter->commit();
        const std::string out = read_bytes(folder_.file(name));
        return out.substr(0, out.find("element"));
    };
    const std::string head = "ply\nformat ascii 1.0\n", line = "comment slim noise_variance ";
    EXPECT_EQ(lines_of("", 0), head);
    EXPECT_EQ(lines_of("comment a\n", 2e-5), head + line + "2e-05\ncomment a\n");
    EXPECT_EQ(lines_of("comment slim noise_variance 1e-5\n", 2e-5), head + line + "2e-05\n");
    EXPECT_EQ(lines_of("comment slim noise_variance 3e-5\n", 2e-5), head + line + "3e-05\n");
    EXPECT_EQ(lines_of("comment slim noise_variance 3e-5\n", 0), head + line + "3e-05\n");
    EXPECT_EQ(lines_of("", 2e-5, "n.xyz"), "1 2 3\n");
}

TEST_F(CloudRewriterTest, AsciiKeepsEveryWordOfPointsThatStay) {
    const std::string head =
        "ply\nformat ascii 1.0\ncomment hello   there\nelement vertex 3\nproperty uchar red\n"
        "property double x\nproperty double y\nproperty double z\n";
    const std::string faces =
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    EXPECT_EQ(
        rewritten("a.ply",
                  head + faces + "7 403000.10 1e0 +2\n8 403001.123456 5 6\n9 1 2 3\n3 0 1 2\n"),
        head +
            "property float nx\nproperty float ny\nproperty float nz\nproperty float "
            "scalar_displacement\n" +
            faces +
            "7 403000.10 1e0 +2 0 0 0 0\n8 403001.373456 5.000 6.000 0 0 1 0.25\n9 1 2 3 0 0 0 0\n"
            "3 0 1 2\n");
}

TEST_F(CloudRewriterTest, AsciiFloatsOfManyDigitsKeepThem) {
    // Georeferenced coordinates declared float: text holds what a float does not.
    const std::string out =
        rewritten("u.ply",
                  "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                  "property float z\nend_header\n1 2 3\n3604900.123 403000.25 1.5\n");
    EXPECT_NE(out.find("\n3604900.373 403000.250 1.5 0 0 1 0.25\n"), std::string::npos) << out;
}

TEST_F(CloudRewriterTest, AListWhereANumberIsToBeWrittenIsRefused) {
    const std::string in =
        folder_.write("l.ply",
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                      "property float y\nproperty float z\nproperty list uchar float nx\n"
                      "end_header\n1 2 3 1 0\n");
    EXPECT_THROW(rewrite_cloud(in, folder_.file("out.ply"), 0.001), FormatError);
}

TEST_F(CloudRewriterTest, BinaryOfEitherOrderKeepsTypesAndOtherBytes) {
    for (const bool big : {false, true}) {
        const std::string head =
            std::string("ply\nformat binary_") + (big ? "big" : "little") +
            "_endian 1.0\nelement vertex 2\nproperty ushort tag\nproperty double x\nproperty "
            "double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float "
            "nz\nproperty float scalar_displacement\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        const auto row = [&](std::uint16_t tag, double x, float nz, float moved) {
            return raw(tag, big) + raw(x, big) + raw(5.0, big) + raw(6.0, big) + raw(0.0f, big) +
                   raw(0.0f, big) + raw(nz, big) + raw(moved, big);
        };
        const std::string tail = std::string("\3") + raw(0, big) + raw(1, big) + raw(1, big);
        EXPECT_EQ(
            rewritten("b.ply", head + row(513, 4e6 + 1e-9, -1, 9) + row(514, 4e6, -1, 9) + tail),
            head + row(513, 4e6 + 1e-9, -1, 0) + row(514, 4e6 + 0.25, 1, 0.25) + tail);
    }
}

TEST_F(CloudRewriterTest, IntegerCoordinatesBecomeDouble) {
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n";
    const std::string in = head + "property int x\nproperty int y\nproperty int z\nend_header\n" +
                           raw(1) + raw(2) + raw(3) + raw(4) + raw(5) + raw(6);
    const std::string out = rewritten("i.ply", in);
    EXPECT_NE(out.find("property double x\nproperty double y"), std::string::npos);
    const PointChunk points = read_all(folder_.file("i.ply"));
    EXPECT_EQ(points.position[0], (Vec3d{1, 2, 3}));
    EXPECT_EQ(points.position[1], (Vec3d{4.25, 5, 6}));
}

TEST_F(CloudRewriterTest, ListsOfAVertexAndElementsBeforeItAreCarried) {
    const std::string head =
        "ply\nformat binary_little_endian 1.0\nelement camera 1\nproperty list uchar float v\n"
        "element vertex 2\nproperty float x\nproperty list uchar short who\nproperty float "
        "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
    const std::string camera = std::string("\2") + raw(1.5f) + raw(2.5f);
    const auto row = [&](float x, float nz) {
        return raw(x) + "\1" + raw(std::int16_t{77}) + raw(0.0f) + raw(0.0f) + raw(0.0f) +
               raw(0.0f) + raw(nz);
    };
    const std::string out =
        rewritten("l.ply", head + "end_header\n" + camera + row(1, -1) + row(2, -1));
    EXPECT_EQ(out, head + "property float scalar_displacement\nend_header\n" + camera + row(1, -1) +
                       raw(0.0f) + row(2.25f, 1) + raw(0.25f));
}

TEST_F(CloudRewriterTest, PositionsAreWrittenLocalToTheOriginOfTheHeader) {
    const std::string head =
        "ply\nformat ascii 1.0\ncomment slim origin 1000 0 0\nelement vertex 2\nproperty float x\n"
        "property float y\nproperty float z\n";
    rewritten("o.ply", head + "end_header\n1 0 0\n2 0 0\n");
    EXPECT_NE(read_bytes(folder_.file("o.ply")).find("\n2.25 0 0 0 0 1 0.25\n"), std::string::npos);
    EXPECT_EQ(read_all(folder_.file("o.ply")).position[1], (Vec3d{1002.25, 0, 0}));
}

TEST_F(CloudRewriterTest, TextKeepsColumnsCommentsAndSeparators) {
    EXPECT_EQ(rewritten("t.csv", "# a scan\nx,y,z,intensity\n1,2,3,9\n\n4.5,5,6,8\n# end\n"),
              "# a scan\nx,y,z,intensity\n1,2,3,9\n\n4.750,5.000,6.000,8\n# end\n");
    EXPECT_EQ(rewritten("t.pts", "3\n1 2 3\n4 5 6.0000001\n7 8 9\n"),
              "3\n1 2 3\n4.250 5.000 6.0000001\n7 8 9\n");
}

TEST_F(CloudRewriterTest, TextKeepsItsByteOrderMark) {
    const std::string mark = "\xef\xbb\xbf";
    EXPECT_EQ(rewritten("m.xyz", mark + "1 2 3\n4 5 6\n"), mark + "1 2 3\n4.250 5.000 6.000\n");
    EXPECT_EQ(rewritten("m.csv", mark + "x,y,z\n1,2,3\n4,5,6\n"),
              mark + "x,y,z\n1,2,3\n4.250,5.000,6.000\n");
    EXPECT_EQ(rewritten("m.pts", mark + "2\n1 2 3\n4 5 6\n"),
              mark + "2\n1 2 3\n4.250 5.000 6.000\n");
}

TEST_F(CloudRewriterTest, ChunksDoNotMatter) {
    std::string bytes = "x y z\n";
    for (int i = 0; i < 100; ++i) bytes += std::to_string(i) + "  2\t3\n";
    const std::string once = rewritten("c.xyz", bytes, 1e-3, 1000);
    EXPECT_EQ(rewritten("c.xyz", bytes, 1e-3, 3), once);
}

TEST_F(CloudRewriterTest, AnotherFormatsNameIsRefused) {
    const std::string in = folder_.write("in.xyz", "1 2 3\n");
    try {
        rewrite_cloud(in, folder_.file("out.ply"), 1e-3);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::usage);
        EXPECT_NE(std::string(error.what()).find("out.ply"), std::string::npos);
    }
    EXPECT_EQ(folder_.n_files(), 1u);
}

TEST_F(CloudRewriterTest, ADamagedTailLeavesNoOutput) {
    const std::string in = folder_.write(
        "in.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "1 2 3\n3 0\n");
    {
        const auto rewriter = rewrite_cloud(in, folder_.file("out.ply"), 1e-3);
        rewriter->write(std::vector<RewrittenPoint>{{{1, 2, 3}, {}, 0, false}});
        EXPECT_THROW(rewriter->commit(), FormatError);
    }
    EXPECT_EQ(folder_.n_files(), 1u);
}

}  // namespace
}  // namespace slim::test
