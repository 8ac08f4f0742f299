#include "formats/slice_file.h"

#include "tests/formats/file_support.h"

#include <functional>
#include <string>
#include <vector>

namespace slim::test {
namespace {

PointBlock some_points(bool normals, bool scans) {
    PointBlock block;
    block.origin = {400000, 0.5, -3};
    for (int i = 0; i < 5; ++i) {
        block.position.push_back({i * 0.1, i + 1.0, -i / 3.0});
        block.id.push_back(static_cast<std::uint64_t>(10 * i));
        if (normals) block.normal.push_back({0, 0, static_cast<float>(i)});
        if (scans) block.scan.push_back(static_cast<std::uint16_t>(i));
    }
    return block;
}

std::function<bool(const Vec3d&)> between(double lo, double hi) {
    return [=](const Vec3d& p) { return p.y >= lo && p.y <= hi; };
}

TEST(SliceFile, RoundTripsWithAndWithoutOptionalColumns) {
    const TempFolder folder;
    for (const bool normals : {false, true})
        for (const bool scans : {false, true}) {
            const PointBlock block = some_points(normals, scans);
            write_slice(folder.file("s"), block);
            const PointBlock back = read_slice(folder.file("s"));
            EXPECT_EQ(back.origin, block.origin);
            EXPECT_EQ(back.position, block.position);
            EXPECT_EQ(back.normal, block.normal);
            EXPECT_EQ(back.id, block.id);
            EXPECT_EQ(back.scan, block.scan);
        }
}

TEST(SliceFile, IsReadInPartAndSeesDamageThere) {
    const TempFolder folder;
    PointBlock block;  // several pieces of 1 MiB
    for (std::size_t i = 0; i < 150000; ++i) {
        block.position.push_back({1, double(i % 1000), 2});
        block.id.push_back(i);
        block.normal.push_back({0, 0, float(i)});
    }
    const std::string path = folder.file("s");
    write_slice(path, block);
    PointBlock part;
    append_slice_part(path, between(990, 991), part);
    ASSERT_EQ(part.size(), 300u);
    for (std::size_t k = 0; k < part.size(); ++k) {
        const std::size_t i = 1000 * (k / 2) + 990 + k % 2;
        ASSERT_EQ(part.id[k], i);
        ASSERT_EQ(part.position[k], block.position[i]);
        ASSERT_EQ(part.normal[k], block.normal[i]);
    }
    append_slice_part(path, between(2000, 3000), part);
    EXPECT_EQ(part.size(), 300u);
    append_slice_points(path, [](std::uint64_t id) { return id == 7 || id == 149999; }, part);
    ASSERT_EQ(part.size(), 302u);
    EXPECT_EQ(part.id[300], 7u);
    EXPECT_EQ(part.position[301], block.position[149999]);
    EXPECT_EQ(part.normal[301], block.normal[149999]);
    std::string bytes = read_bytes(path);
    // of a position that is not asked for or is
    bytes[2000000] = static_cast<char>(bytes[2000000] ^ 4);
    const std::string damaged = folder.write("d", bytes);
    EXPECT_NE(
        error_of([&] { append_slice_part(damaged, between(5, 6), part); }).find("chunk position"),
        std::string::npos);
    EXPECT_NE(error_of([&] { read_slice(damaged); }).find("does not match its checksum"),
              std::string::npos);
}

}  // namespace
}  // namespace slim::test
