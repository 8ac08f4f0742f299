#include "formats/chunk_file.h"

#include "tests/formats/file_support.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace slim::test {
namespace {

constexpr ChunkFileKind kKind{"SLIMTEST", "test file", 2};

void write_chunks(const std::string& path, const ChunkFileKind& kind) {
    ChunkWriter writer(path, kind);
    const std::vector<double> numbers{1, 2.5, -3};
    const std::vector<std::uint16_t> shorts{7, 8, 9, 10, 11};
    writer.add("numbers", std::span<const double>(numbers));
    writer.add("none", std::span<const float>());
    writer.add("shorts", std::span<const std::uint16_t>(shorts));
    writer.commit();
}

void read_chunks(const std::string& path) {
    const ChunkFile file = ChunkFile::open(path, kKind);
    file.verify_all();
    EXPECT_EQ(file.array<double>("numbers").size(), 3u);
}

TEST(ChunkFile, GivesBackWhatWasWritten) {
    const TempFolder folder;
    write_chunks(folder.file("a"), kKind);
    const ChunkFile file = ChunkFile::open(folder.file("a"), kKind);
    EXPECT_EQ(file.names(), (std::vector<std::string>{"numbers", "none", "shorts"}));
    EXPECT_EQ(file.array<double>("numbers")[1], 2.5);
    EXPECT_EQ(file.array<std::uint16_t>("shorts")[4], 11);
    EXPECT_TRUE(file.array<float>("none").empty());
    EXPECT_EQ(file.offset("shorts") % 64, 0u);
    EXPECT_NE(error_of([&] { file.array<double>("other"); }).find("no chunk other"),
              std::string::npos);
    EXPECT_NE(error_of([&] { file.array<float>("numbers"); }).find("4 bytes, found 8"),
              std::string::npos);
}

TEST(ChunkFile, ChunksMayBeFilledInAnyInterleaving) {
    const TempFolder folder;
    write_chunks(folder.file("a"), kKind);
    ChunkWriter writer(folder.file("b"), kKind);
    const std::vector<double> numbers{1, 2.5, -3};
    const std::vector<std::uint16_t> shorts{7, 8, 9, 10, 11};
    const auto n = writer.reserve("numbers", 8, 3);
    writer.reserve("none", 4, 0);
    const auto s = writer.reserve("shorts", 2, 5);
    writer.append(s, shorts.data(), 2);
    writer.append(n, numbers.data(), 1);
    writer.append(s, shorts.data() + 2, 3);
    writer.append(n, numbers.data() + 1, 2);
    writer.commit();
    EXPECT_EQ(read_bytes(folder.file("a")), read_bytes(folder.file("b")));
}

TEST(ChunkFile, SeesEveryFlippedByteAndEveryTruncation) {
    const TempFolder folder;
    write_chunks(folder.file("a"), kKind);
    expect_every_damage_is_seen(folder, read_bytes(folder.file("a")), read_chunks);
}

TEST(ChunkFile, ReadsOlderVersionsAndRefusesNewerAndForeignFiles) {
    const TempFolder folder;
    write_chunks(folder.file("old"), {kKind.magic, "", 1});
    EXPECT_EQ(ChunkFile::open(folder.file("old"), kKind).version(), 1u);
    write_chunks(folder.file("new"), {kKind.magic, "", 3});
    EXPECT_NE(error_of([&] { read_chunks(folder.file("new")); })
                  .find("written by a newer slim: test file version 3, this one reads up to 2"),
              std::string::npos);
    write_chunks(folder.file("other"), {"SLIMELSE", "", 1});
    EXPECT_NE(error_of([&] { read_chunks(folder.file("other")); }).find("this is not a test file"),
              std::string::npos);
    const std::string damaged_chunk = [&] {
        write_chunks(folder.file("c"), kKind);
        std::string bytes = read_bytes(folder.file("c"));
        bytes[64] = static_cast<char>(bytes[64] ^ 1);
        return folder.write("c", bytes);
    }();
    EXPECT_NE(error_of([&] { read_chunks(damaged_chunk); }).find("byte 64: damaged: chunk numbers"),
              std::string::npos);
}

}  // namespace
}  // namespace slim::test
