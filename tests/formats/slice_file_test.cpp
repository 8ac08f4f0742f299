#include "formats/slice_file.h"

#include "formats/slice_kind.h"
#include "tests/formats/file_support.h"

#include <cstdint>
#include <functional>
#include <span>
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

/// Appends the points of a slice between two heights, whose pieces' boxes say which to read.
void append_between(const std::string& path, double lo, double hi, PointBlock& out) {
    SliceSelection part;
    part.add(
        path,
        [=](const Bbox& box) {
            if (box.hi.y < lo || box.lo.y > hi) return WantedOf::none;
            return box.lo.y >= lo && box.hi.y <= hi ? WantedOf::all : WantedOf::some;
        },
        [=](const Vec3d& p) { return p.y >= lo && p.y <= hi; });
    part.append_to(out);
}

void append_ids(const std::string& path, const std::function<bool(std::uint64_t)>& is_wanted,
                PointBlock& out) {
    SliceSelection part;
    part.add(path, is_wanted);
    part.append_to(out);
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

/// Rows of a thousand points each at one height, which rises.
PointBlock rising_points(std::size_t n) {
    PointBlock block;
    for (std::size_t i = 0; i < n; ++i) {
        block.position.push_back({double(i % 1000), double(i / 1000), 2});
        block.id.push_back(i);
        block.normal.push_back({0, 0, float(i)});
    }
    return block;
}

TEST(SliceFile, KeepsEveryBitOfPositionsAndIdsInAsFewBytesAsHoldThem) {
    const TempFolder folder;
    PointBlock floats = rising_points(5000), doubles = floats, far = floats;
    doubles.position[4999].y = 0.1;  // no float: of the second piece alone
    far.id[0] = 0xffffffffffffffffu;
    std::size_t sizes[3];
    const PointBlock* const blocks[] = {&floats, &doubles, &far};
    for (std::size_t k = 0; k < 3; ++k) {
        write_slice(folder.file("s"), *blocks[k]);
        const PointBlock back = read_slice(folder.file("s"));
        EXPECT_EQ(back.position, blocks[k]->position);
        EXPECT_EQ(back.id, blocks[k]->id);
        sizes[k] = read_bytes(folder.file("s")).size();
    }
    EXPECT_NEAR(static_cast<double>(sizes[0]), 5000 * 28, 1000);
    const auto more = [&](std::size_t k) { return static_cast<double>(sizes[k] - sizes[0]); };
    EXPECT_NEAR(more(1), 2500 * 12, 64);  // chunks are padded
    EXPECT_NEAR(more(2), 2500 * 4, 64);
}

/// Points of each piece of a slice.
std::vector<std::uint32_t> piece_sizes(const std::string& path) {
    std::vector<std::uint32_t> out;
    const ChunkFile slice = ChunkFile::open(path, kSliceKind);
    for (const SlicePiece& p : slice.array<SlicePiece>("pieces")) out.push_back(p.n_points);
    return out;
}

TEST(SliceFile, NoPieceIsSmallButTheLast) {
    const TempFolder folder;
    const std::string path = folder.file("s");
    const auto sizes_of = [&](const std::vector<std::size_t>& parts) {
        std::size_t n = 0;
        for (const std::size_t part : parts) n += part;
        SliceWriter writer(path, {}, n, true, false);
        for (const std::size_t part : parts) writer.append(rising_points(part));
        writer.commit();
        return piece_sizes(path);
    };
    using Sizes = std::vector<std::uint32_t>;
    EXPECT_EQ(sizes_of({4097}), (Sizes{2048, 2049}));
    EXPECT_EQ(sizes_of({8192, 100}), (Sizes{4096, 4096, 100}));
    EXPECT_EQ(sizes_of({100, 300, 200, 511, 512}), (Sizes{600, 1023}));
    EXPECT_EQ(sizes_of({100, 12288}), (Sizes{3097, 3097, 3097, 3097}));
}

TEST(SliceFile, PointsApartShareNoPieceWithOthers) {
    const TempFolder folder;
    const std::string path = folder.file("s");
    PointBlock inner = rising_points(300), rim = inner;
    for (Vec3d& p : rim.position) p.z = 50;
    SliceWriter writer(path, {}, 1500, true, false);
    for (const auto apart : {false, true, true, false, true})
        writer.append(apart ? rim : inner,
                      apart ? SliceWriter::Apart::yes : SliceWriter::Apart::no);
    writer.commit();
    const ChunkFile slice = ChunkFile::open(path, kSliceKind);
    for (const SlicePiece& p : slice.array<SlicePiece>("pieces")) EXPECT_EQ(p.box.lo.z, p.box.hi.z);
    EXPECT_EQ(piece_sizes(path), (std::vector<std::uint32_t>{600, 600, 300}));
    EXPECT_EQ(read_slice(path).size(), 1500u);
}

TEST(SliceFile, ChosenPointsAreWrittenAsIfThereWereNoOthers) {
    const TempFolder folder;
    for (const std::size_t n : {700u, 5000u, 60000u}) {
        PointBlock block = rising_points(n), alone;
        block.scan.resize(n);
        std::vector<bool> chosen(n);
        for (std::size_t i = 0; i < n; ++i) {
            block.scan[i] = static_cast<std::uint16_t>(i % 7);
            chosen[i] = i % 3 != 0 && (i < 900 || i > 2500);  // a gap wider than a third of a piece
            if (!chosen[i]) continue;
            alone.position.push_back(block.position[i]);
            alone.normal.push_back(block.normal[i]);
            alone.id.push_back(block.id[i]);
            alone.scan.push_back(block.scan[i]);
        }
        write_slice(folder.file("alone"), alone);
        SliceWriter writer(folder.file("chosen"), block.origin, alone.size(), true, true);
        writer.append(block, chosen);
        writer.commit();
        EXPECT_EQ(read_bytes(folder.file("chosen")), read_bytes(folder.file("alone"))) << n;
    }
}

TEST(SliceFile, ReadsTheSameOfPointsThatComeOneByOne) {
    const TempFolder folder;
    const PointBlock block = rising_points(1300);
    SliceWriter writer(folder.file("s"), block.origin, block.size(), true, false);
    for (std::size_t i = 0; i < block.size(); ++i) {
        PointBlock one;
        one.position = {block.position[i]};
        one.id = {block.id[i]};
        one.normal = {block.normal[i]};
        writer.append(one);
    }
    writer.commit();
    const PointBlock back = read_slice(folder.file("s"));
    EXPECT_EQ(back.position, block.position);
    EXPECT_EQ(back.id, block.id);
    EXPECT_EQ(back.normal, block.normal);
    EXPECT_LT(read_bytes(folder.file("s")).size(), 1300 * 29u + 1000u);
}

TEST(SliceFile, IsReadInPartAndSeesDamageThere) {
    const TempFolder folder;
    const PointBlock block = rising_points(150000);
    const std::string path = folder.file("s");
    write_slice(path, block);
    PointBlock part;
    append_between(path, 49, 50, part);
    ASSERT_EQ(part.size(), 2000u);
    for (std::size_t k = 0; k < part.size(); ++k) {
        ASSERT_EQ(part.id[k], 49000 + k);
        ASSERT_EQ(part.position[k], block.position[49000 + k]);
        ASSERT_EQ(part.normal[k], block.normal[49000 + k]);
    }
    append_between(path, 2000, 3000, part);
    EXPECT_EQ(part.size(), 2000u);
    append_ids(path, [](std::uint64_t id) { return id == 7 || id == 149999; }, part);
    ASSERT_EQ(part.size(), 2002u);
    EXPECT_EQ(part.id[2000], 7u);
    EXPECT_EQ(part.position[2001], block.position[149999]);
    EXPECT_EQ(part.normal[2001], block.normal[149999]);
    std::string bytes = read_bytes(path);
    bytes[2000000] = static_cast<char>(bytes[2000000] ^ 4);  // of point 70,000 or so
    const std::string damaged = folder.write("d", bytes);
    PointBlock elsewhere;
    append_between(damaged, 0, 10, elsewhere);  // whose pieces are whole
    EXPECT_EQ(elsewhere.size(), 11000u);
    EXPECT_NE(
        error_of([&] { append_between(damaged, 71, 72, part); }).find("piece 17 of the points"),
        std::string::npos);
    EXPECT_NE(error_of([&] { append_ids(damaged, [](std::uint64_t) { return false; }, part); })
                  .find("does not match its checksum"),
              std::string::npos);
    const std::string error = error_of([&] { read_slice(damaged); });
    EXPECT_TRUE(error.ends_with("does not match its checksum")) << error;
    EXPECT_TRUE(error_of([&] {
                    read_slice(folder.write("points.slice", bytes));
                }).ends_with("run `slim slice` again"));
    EXPECT_TRUE(error_of([&] {
                    read_slice(folder.write("oriented.slice", bytes));
                }).ends_with("run `slim normals` again"));
}

TEST(SliceFile, KnowsItselfByItsTableAndDamageByItsBytes) {
    const TempFolder folder;
    PointBlock block = rising_points(9000);
    write_slice(folder.file("a"), block);
    const std::string identity = slice_identity(folder.file("a"));
    EXPECT_TRUE(is_whole_slice(folder.file("a"), identity));
    std::string bytes = read_bytes(folder.file("a"));
    bytes[100000] = static_cast<char>(bytes[100000] ^ 1);
    EXPECT_FALSE(is_whole_slice(folder.write("d", bytes), identity));
    EXPECT_FALSE(is_whole_slice(folder.write("d", bytes.substr(0, 5000)), identity));
    EXPECT_FALSE(is_whole_slice(folder.file("none"), identity));
    block.id[8999] = 9001;
    write_slice(folder.file("b"), block);
    EXPECT_NE(slice_identity(folder.file("b")), identity);
}

TEST(SliceFile, JoinsSlicesInOneSelection) {
    const TempFolder folder;
    const PointBlock block = some_points(true, true);
    write_slice(folder.file("a"), block);
    write_slice(folder.file("b"), block);
    write_slice(folder.file("bare"), some_points(false, true));
    const auto from = [&](const std::vector<std::string>& names) {
        SliceSelection chosen;
        for (const std::string& name : names)
            chosen.add(folder.file(name), [](std::uint64_t id) { return id >= 30; });
        PointBlock out;
        chosen.append_to(out);
        return out;
    };
    const PointBlock both = from({"a", "b"});
    EXPECT_EQ(both.id, (std::vector<std::uint64_t>{30, 40, 30, 40}));
    EXPECT_EQ(both.scan, (std::vector<std::uint16_t>{3, 4, 3, 4}));
    EXPECT_EQ(both.origin, block.origin);
    const auto expect_said = [&](const std::string& error, const std::vector<std::string>& words) {
        for (const std::string& word : words)
            EXPECT_NE(error.find(word), std::string::npos) << word << " in " << error;
    };
    expect_said(
        error_of([&] {
            from({"a", "bare"});
        }),
        {folder.file("bare") + ": byte ", "other columns",
         "expected normals and scans, as in " + folder.file("a"), "found no normals and scans"});
    PointBlock moved = block;
    moved.origin.x += 0.25;
    write_slice(folder.file("moved"), moved);
    expect_said(
        error_of([&] {
            from({"a", "moved"});
        }),
        {folder.file("moved") + ": byte ", "another origin",
         "expected (400000, 0.5, -3), as in " + folder.file("a"), "found (400000.25, 0.5, -3)"});
    PointBlock here = block;
    here.origin = {};
    SliceSelection chosen;
    chosen.add(folder.file("a"), [](std::uint64_t) { return true; });
    expect_said(error_of([&] { chosen.append_to(here); }),
                {"another origin", "as of the points that it is added to"});
}

TEST(SliceFile, RefusesTheVersionBeforeByName) {
    const TempFolder folder;
    ChunkWriter old(folder.file("s"), {"SLIMSLCE", "SLIM slice", 1});
    old.commit();
    EXPECT_NE(error_of([&] { read_slice(folder.file("s")); }).find("version 1, of an earlier slim"),
              std::string::npos);
}

TEST(SliceFile, RefusesALaterVersionByName) {
    const TempFolder folder;
    ChunkWriter later(folder.file("s"), {"SLIMSLCE", "SLIM slice", kSliceKind.version + 1});
    later.commit();
    const std::string error = error_of([&] { read_slice(folder.file("s")); });
    EXPECT_NE(error.find("version " + std::to_string(kSliceKind.version + 1)), std::string::npos)
        << error;
}

TEST(SliceFile, SeesEveryDamage) {
    const TempFolder folder;
    write_slice(folder.file("s"), some_points(true, true));
    expect_every_damage_is_seen(folder, read_bytes(folder.file("s")),
                                [](const std::string& path) { read_slice(path); });
}

TEST(SliceFile, NamesTheFaultOfAPieceWhoseChecksumsAreRight) {
    const TempFolder folder;
    const PointBlock block = some_points(false, false);
    const EncodedPiece good = encode_piece(block, 0, block.size());
    const std::string path = folder.file("s");
    const auto error_with = [&](const std::function<void(SlicePiece&)>& change) {
        ChunkWriter writer(path, kSliceKind);
        writer.add("origin", std::span<const Vec3d>(&block.origin, 1));
        const SliceColumns columns{0, 0};
        writer.add("columns", std::span<const SliceColumns>(&columns, 1));
        std::vector<unsigned char> bytes = good.bytes;
        bytes.insert(bytes.end(), good.bytes.begin(), good.bytes.end());
        writer.add("points", std::span<const unsigned char>(bytes));
        std::vector<SlicePiece> pieces(2, good.piece);
        pieces[0].first_byte = 0, pieces[1].first_byte = good.bytes.size();
        change(pieces[1]);
        writer.add("pieces", std::span<const SlicePiece>(pieces));
        writer.commit();
        return error_of([&] { read_slice(path); });
    };
    const auto expect_said = [&](const std::function<void(SlicePiece&)>& change, std::size_t field,
                                 const char* words) {
        const std::string error = error_with(change);
        const ChunkFile slice = ChunkFile::open(path, kSliceKind);
        const std::string place =
            path + ": byte " + std::to_string(slice.offset("pieces") + 80 + field) + ": ";
        EXPECT_EQ(error.find(place), 0u) << error << "\nexpected " << place;
        EXPECT_NE(error.find(words), std::string::npos) << error;
    };
    EXPECT_EQ(error_with([](SlicePiece&) {}), "");
    expect_said([](SlicePiece& p) { p.first_byte += 8; }, 48, "expected the first byte 144, where");
    expect_said([](SlicePiece& p) { p.coordinate_bytes = 6; }, 76,
                "coordinates of 4 or 8 bytes, found 6");
    expect_said([](SlicePiece& p) { p.id_bytes = 0; }, 78, "ids of 4 or 8 bytes, found 0");
    expect_said([](SlicePiece& p) { p.n_points = 0; }, 72, "at least one point, found 0");
    expect_said([](SlicePiece& p) { p.n_points = 4000000000u; }, 72, "at most 144 bytes");
    EXPECT_NE(error_with([](SlicePiece& p) { p.n_points = 2; }).find("chunk points: expected "),
              std::string::npos);
}

}  // namespace
}  // namespace slim::test
