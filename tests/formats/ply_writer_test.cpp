#include "formats/ply_writer.h"

#include "formats/ply_faces.h"
#include "formats/truth_file.h"
#include "tests/formats/file_support.h"

#include <string>
#include <vector>

namespace slim::test {
namespace {

TEST(PlyWriter, WritesWhatTheReaderReads) {
    const TempFolder folder;
    for (const bool ascii : {false, true}) {
        PlyLayout layout;
        layout.ascii = ascii;
        layout.double_positions = layout.normals = layout.scan = layout.colours = true;
        layout.scalars = {"scalar_k1", "quality"};
        layout.origin = Vec3d{403000.123456, 3604900.5, 1000};
        layout.comments = {"one line"};
        PlyWriter writer(folder.file("w.ply"), layout);
        const std::vector<Vec3d> positions{{0.1, 0.2, 0.3}, {1, 2, 3}, {-1e-9, 4, 5}};
        const std::vector<Vec3f> normals{{0, 0, 1}, {0, 1, 0}, {0.6f, 0.8f, 0}};
        const std::vector<std::uint16_t> scans{1, 2, 60000};
        const std::vector<std::uint8_t> colours(9, 200);
        const std::vector<float> scalars{1, 2, 3, 4, 5, 6};
        writer.write({positions, normals, colours, scans, scalars});
        writer.write({positions, normals, colours, scans, scalars});
        writer.commit();
        const PointChunk points = read_all(folder.file("w.ply"));
        ASSERT_EQ(points.size(), 6u);
        EXPECT_EQ(points.position[5], positions[2] + *layout.origin);
        EXPECT_EQ(points.normal[5], normals[2]);
        EXPECT_EQ(points.scan[5], 60000);
        const auto source = open_cloud(folder.file("w.ply"));
        EXPECT_EQ(source->info().origin, layout.origin);
        EXPECT_EQ(source->info().colors, (std::vector<std::string>{"red", "green", "blue"}));
        EXPECT_EQ(source->info().skipped, (std::vector<std::string>{"scalar_k1", "quality"}));
    }
}

TEST(PlyWriter, FacesFollowThePoints) {
    const TempFolder folder;
    for (const bool ascii : {false, true})
        for (const bool large : {false, true}) {
            PlyLayout layout;
            layout.ascii = ascii, layout.large_faces = large, layout.n_faces = 2;
            PlyWriter writer(folder.file("w.ply"), layout);
            const std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
            writer.write({positions, {}, {}, {}, {}});
            const std::vector<std::uint32_t> a{0, 1, 2}, b{0, 1, 2, 3};
            writer.write_face(a), writer.write_face(b);
            writer.commit();
            std::vector<std::vector<std::size_t>> faces;
            read_ply_faces(folder.file("w.ply"), 4, [&](auto corners) {
                faces.emplace_back(corners.begin(), corners.end());
            });
            EXPECT_EQ(faces, (std::vector<std::vector<std::size_t>>{{0, 1, 2}, {0, 1, 2, 3}}));
        }
}

TEST(PlyWriter, LeavesNothingWithoutACommit) {
    const TempFolder folder;
    const std::vector<Vec3d> positions{{0.1, 0.2, 0.3}};
    {
        PlyWriter writer(folder.file("w.ply"), {});
        writer.write({positions, {}, {}, {}, {}});
    }
    EXPECT_EQ(folder.n_files(), 0u);
    PlyWriter writer(folder.file("w.ply"), {});
    writer.write({positions, {}, {}, {}, {}});
    writer.commit();
    EXPECT_EQ(read_all(folder.file("w.ply")).position[0], (Vec3d{0.1f, 0.2f, 0.3f}));
}

TEST(TruthFile, RoundTripsAndHoldsItsLengthAgainstTheCloud) {
    const TempFolder folder;
    const std::vector<PointTruth> truth{{{0, 0, 1}, 2, 1}, {{0, 1, 0}, 0.5, -0.5}};
    TruthWriter writer(folder.file("c.truth"));
    writer.write(truth);
    writer.commit();
    EXPECT_EQ(read_bytes(folder.file("c.truth")).size(), 80u);
    const auto back = read_truth(folder.file("c.truth"), 2);
    EXPECT_EQ(back[1].normal, (Vec3d{0, 1, 0}));
    EXPECT_EQ(back[1].k2, -0.5);
    EXPECT_NE(error_of([&] { read_truth(folder.file("c.truth"), 3); }).find("expected 3 points"),
              std::string::npos);
    EXPECT_NE(error_of([&] { read_truth(folder.file("none"), 3); }), "");
    TruthReader parts(folder.file("c.truth"));
    std::vector<PointTruth> part;
    parts.read(1, "c.ply", part);
    parts.read(1, "c.ply", part);
    EXPECT_EQ(part[0].k1, 0.5);
    EXPECT_EQ(parts.n_left(), 0u);
    EXPECT_NE(error_of([&] { parts.read(1, "c.ply", part); }).find("c.ply has more points"),
              std::string::npos);
    folder.write("odd.truth", std::string(41, '\0'));
    EXPECT_NE(error_of([&] { TruthReader(folder.file("odd.truth")); }).find("found 41 bytes"),
              std::string::npos);
    EXPECT_EQ(truth_path("a/cloud.ply"), "a/cloud.truth");
    EXPECT_EQ(truth_path("a/cloud.xyz.gz"), "a/cloud.truth");
}

}  // namespace
}  // namespace slim::test
