#include "tests/formats/format_support.h"

#include "formats/atomic_file.h"
#include "formats/chunk_file.h"
#include "formats/fit_file.h"
#include "formats/model_file.h"
#include "formats/ply_writer.h"
#include "formats/slice_file.h"
#include "formats/truth_file.h"
#include "slim/model/surfel_encoder.h"

#include <csignal>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace slim::test {
namespace {

constexpr ChunkFileKind kKind{"SLIMTEST", "test file", 2};

std::string error_of(const std::function<void()>& action) {
    try {
        action();
        return {};
    } catch (const Error& error) {
        return error.what();
    }
}

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

/// read() must refuse the file with any one byte changed and with any number of bytes missing.
void expect_every_damage_is_seen(const TempFolder& folder, const std::string& bytes,
                                 const std::function<void(const std::string&)>& read) {
    ASSERT_EQ(error_of([&] { read(folder.write("sound", bytes)); }), "");
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string damaged = bytes;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        const std::string path = folder.write("damaged", damaged);
        const std::string error = error_of([&] { read(path); });
        ASSERT_EQ(error.find(path + ": byte "), 0u) << "byte " << i << ": " << error;
    }
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        const std::string path = folder.write("cut", bytes.substr(0, n));
        ASSERT_EQ(error_of([&] { read(path); }).find(path), 0u) << n;
    }
    EXPECT_NE(error_of([&] { read(folder.write("long", bytes + '\0')); }), "");
}

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

FittedSurfel some_surfel(double x) {
    Surfel surfel{{x, 1, 2}, 0.5, frame_from_normal(round_normal(Vec3d{0, 0.6, 0.8})), {}, 2};
    surfel.polynomial.a = {0.1, 0, 0, 0.25, -0.5, 0.75};
    FittedSurfel fitted{surfel};
    fitted.fit_error = 0.01;
    fitted.n_points = 55;
    fitted.level = 3;
    fitted.flags = kLeaf;
    fitted.point_id = 123456789012345;
    return fitted;
}

/// A root with two leaves.
SurfelTreeData some_model() {
    SurfelTreeData data;
    data.header.degree = 2;
    data.header.origin = {1e6, 0, 0};
    data.header.bounds = {{0, 0, 0}, {4, 4, 4}};
    data.header.diagonal = 7;
    data.header.mdl_threshold = 0.01;
    data.header.n_points = 110;
    data.header.n_leaves = 2;
    std::vector<Surfel> surfels{some_surfel(2).surfel, some_surfel(1).surfel, some_surfel(3).surfel};
    surfels[0].support_radius = 5;
    encode_surfels(surfels, data);
    data.nodes.resize(3);
    data.nodes[0].first_child = 1;
    data.nodes[0].n_children = 2;
    data.nodes[0].bound_radius = 5;
    for (std::size_t i = 1; i < 3; ++i) {
        data.nodes[i].bound_radius = 0.5f;
        data.nodes[i].level = 1;
        data.nodes[i].degree = 2;
        data.nodes[i].flags = kLeaf;
    }
    return data;
}

TEST(AtomicFile, IsInvisibleUntilCommitted) {
    const TempFolder folder;
    const std::string path = folder.write("a", "old");
    {
        AtomicFile file(path);
        file.write("new");
        EXPECT_EQ(read_bytes(path), "old");
    }
    EXPECT_EQ(read_bytes(path), "old");
    EXPECT_EQ(folder.n_files(), 1u);
    AtomicFile file(path);
    file.write("hallo world");
    file.write_at(1, "e", 1);
    file.write("!");
    EXPECT_EQ(file.size(), 12u);
    file.commit();
    EXPECT_EQ(read_bytes(path), "hello world!");
    EXPECT_EQ(folder.n_files(), 1u);
}

TEST(AtomicFile, ReplacesFilesOnly) {
    const TempFolder folder;
    for (const std::string& path : {std::string("/dev/null"), folder.file(".")}) {
        try {
            AtomicFile file(path);
            FAIL() << path;
        } catch (const IoError& e) {
            EXPECT_EQ(e.code(), ExitCode::usage);
            EXPECT_NE(std::string(e.what()).find("is a "), std::string::npos);
        }
    }
}

TEST(AtomicFile, TemporaryNamesDifferBetweenHosts) {
    const TempFolder folder;
    char host[256] = {};
    ASSERT_EQ(gethostname(host, sizeof host - 1), 0);
    AtomicFile file(folder.file("a"));
    EXPECT_TRUE(std::filesystem::exists(folder.file("a") + temporary_suffix()));
    EXPECT_TRUE(temporary_suffix().starts_with(std::string(".tmp.") + host + "." + std::to_string(getpid())));
}

TEST(AtomicFile, AFullDiskIsAResourceErrorAndLeavesNothing) {
    const TempFolder folder;
    // A file size limit fails a write as a full disk does.
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    ExitCode code = ExitCode::ok;
    std::string said;
    try {
        write_file_atomically(folder.file("big"), std::string(5000, 'x'));
    } catch (const IoError& error) {
        code = error.code();
        said = error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, old_handler);
    EXPECT_EQ(code, ExitCode::resource);
    EXPECT_NE(said.find("byte 1000: cannot be written: File too large (see `ulimit -f`)"),
              std::string::npos)
        << said;
    EXPECT_EQ(folder.n_files(), 0u);
    try {
        write_file_atomically(folder.file("no/such/folder"), "x");
        ADD_FAILURE();
    } catch (const IoError& error) {
        EXPECT_EQ(error.code(), ExitCode::usage);
    }
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
    EXPECT_NE(error_of([&] { file.array<double>("other"); }).find("no chunk other"), std::string::npos);
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

std::function<bool(const Vec3d&)> between(double lo, double hi) {
    return [=](const Vec3d& p) { return p.y >= lo && p.y <= hi; };
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
    bytes[2000000] = static_cast<char>(bytes[2000000] ^ 4);  // of a position that is not asked for or is
    const std::string damaged = folder.write("d", bytes);
    EXPECT_NE(error_of([&] { append_slice_part(damaged, between(5, 6), part); }).find("chunk position"), std::string::npos);
    EXPECT_NE(error_of([&] { read_slice(damaged); }).find("does not match its checksum"), std::string::npos);
}

TEST(FitFile, RoundTripsAndSeesDamage) {
    const TempFolder folder;
    const std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4)};
    write_fit(folder.file("f"), surfels, "{\"lambda\": 0.5}");
    const FitFile fit = read_fit(folder.file("f"));
    EXPECT_EQ(fit.header_json, "{\"lambda\": 0.5}");
    ASSERT_EQ(fit.surfels.size(), 2u);
    const FittedSurfel& back = fit.surfels[1];
    EXPECT_EQ(back.surfel.center, surfels[1].surfel.center);
    EXPECT_EQ(back.surfel.support_radius, 0.5);
    EXPECT_EQ(back.surfel.frame.normal, surfels[1].surfel.frame.normal);
    EXPECT_EQ(back.surfel.frame.u_axis, surfels[1].surfel.frame.u_axis);
    EXPECT_EQ(back.surfel.polynomial.a, surfels[1].surfel.polynomial.a);
    EXPECT_EQ(back.surfel.degree, 2);
    EXPECT_EQ(back.fit_error, 0.01);
    EXPECT_EQ(back.n_points, 55u);
    EXPECT_EQ(back.level, 3);
    EXPECT_EQ(back.flags, kLeaf);
    EXPECT_EQ(back.point_id, 123456789012345u);
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
}

TEST(FitFile, RefusesNumbersThatAreNotFinite) {
    const TempFolder folder;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refuses = [&](auto&& spoil) {
        FittedSurfel s = some_surfel(1);
        spoil(s);
        write_fit(folder.file("f"), std::vector<FittedSurfel>{s}, "{}");
        EXPECT_THROW(read_fit(folder.file("f")), FormatError);
    };
    refuses([&](FittedSurfel& s) { s.surfel.polynomial.a[3] = nan; });
    refuses([&](FittedSurfel& s) { s.surfel.frame.normal.z = nan; });
    refuses([&](FittedSurfel& s) { s.fit_error = nan; });
    refuses([&](FittedSurfel& s) { s.fit_error = -1; });
    refuses([&](FittedSurfel& s) {
        SharpSheets sheets;
        sheets.n_extra = 1;
        sheets.extra[0].polynomial.a[0] = nan;
        s.surfel.sharp = std::make_shared<const SharpSheets>(sheets);
    });
}

TEST(FitFile, KeepsEveryRim) {
    const TempFolder folder;
    std::vector<FittedSurfel> surfels;
    for (int k = 0; k < kRimDirections; ++k)
        for (int reach = 0; reach <= kRimReaches; ++reach) {
            surfels.push_back(some_surfel(static_cast<std::uint64_t>(k)));
            surfels.back().surfel.rim = pack_rim(k, reach > 0 ? kRimStep * reach - 0.01 : 1);
        }
    write_fit(folder.file("f"), surfels, "{}", {});
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 4);  // the version stands behind the magic
    const FitFile fit = read_fit(folder.file("f"));
    ASSERT_EQ(fit.surfels.size(), surfels.size());
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        EXPECT_EQ(fit.surfels[i].surfel.rim, surfels[i].surfel.rim);
        EXPECT_EQ(fit.surfels[i].surfel.degree, surfels[i].surfel.degree);
    }
}

TEST(FitFile, KeepsDroppedPointsAndReadsWhatIsWanted) {
    const TempFolder folder;
    const std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    const std::vector<std::uint64_t> dropped{3, 1, std::uint64_t{1} << 40};
    write_fit(folder.file("f"), surfels, "{}", dropped);
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 3);  // the version stands behind the magic
    const FitFile fit = read_fit(folder.file("f"), [&](const FittedSurfel& s) {
        return s.surfel.center == surfels[1].surfel.center;
    });
    EXPECT_EQ(fit.dropped, dropped);
    ASSERT_EQ(fit.surfels.size(), 1u);
    EXPECT_EQ(fit.surfels[0].surfel.center, surfels[1].surfel.center);
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
}

TEST(FitReader, HandsOutTheSameSurfelsEveryTimeEvenIfAnotherFileTakesTheName) {
    const TempFolder folder;
    const std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    write_fit(folder.file("f"), surfels, "{\"a\": 1}", std::vector<std::uint64_t>{9});
    const FitReader reader(folder.file("f"));
    write_fit(folder.file("f"), std::vector<FittedSurfel>{some_surfel(7)}, "{}");
    EXPECT_EQ(reader.n_surfels(), 3u);
    EXPECT_EQ(reader.header_json(), "{\"a\": 1}");
    EXPECT_EQ(reader.dropped(), std::vector<std::uint64_t>{9});
    for (int pass = 0; pass < 2; ++pass) {
        std::size_t next = 0;
        reader.for_each([&](const FittedSurfel& s) {
            ASSERT_LT(next, surfels.size());
            EXPECT_EQ(s.surfel.center, surfels[next++].surfel.center);
        });
        EXPECT_EQ(next, surfels.size());
    }
}

/// Two further sheets, joined unlike.
std::shared_ptr<const SharpSheets> some_sheets(std::size_t n_extra) {
    auto out = std::make_shared<SharpSheets>();
    out->n_extra = n_extra;
    out->outer = Join::min;
    for (std::size_t k = 0; k < n_extra; ++k) {
        out->extra[k].frame = frame_from_normal(round_normal(
            normalized(Vec3d{1, 0.5 * static_cast<double>(k), -0.25})));
        for (std::size_t i = 0; i < 6; ++i)
            out->extra[k].polynomial.a[i] = 0.125 * static_cast<double>(i + k);
    }
    return out;
}

void expect_equal(const SharpSheets& a, const SharpSheets& b) {
    ASSERT_EQ(a.n_extra, b.n_extra);
    EXPECT_EQ(a.outer, b.outer);
    EXPECT_EQ(a.inner, b.inner);
    for (std::size_t k = 0; k < a.n_extra; ++k) {
        EXPECT_EQ(a.extra[k].frame.normal, b.extra[k].frame.normal);
        EXPECT_EQ(a.extra[k].frame.u_axis, b.extra[k].frame.u_axis);
        EXPECT_EQ(a.extra[k].polynomial.a, b.extra[k].polynomial.a);
    }
}

TEST(FitFile, SharpSurfelsRoundTripAndMakeItVersion2) {
    const TempFolder folder;
    std::vector<FittedSurfel> surfels{some_surfel(1), some_surfel(4), some_surfel(2)};
    write_fit(folder.file("smooth"), surfels, "{}");
    surfels[0].surfel.sharp = some_sheets(2);
    surfels[2].surfel.sharp = some_sheets(1);
    write_fit(folder.file("f"), surfels, "{}");
    // The version stands behind the magic.
    EXPECT_EQ(read_bytes(folder.file("smooth"))[8], 1);
    EXPECT_EQ(read_bytes(folder.file("f"))[8], 2);
    const FitFile fit = read_fit(folder.file("f"));
    ASSERT_EQ(fit.surfels.size(), 3u);
    EXPECT_FALSE(fit.surfels[1].surfel.sharp);
    for (const std::size_t i : {0u, 2u}) {
        ASSERT_TRUE(fit.surfels[i].surfel.sharp);
        expect_equal(*fit.surfels[i].surfel.sharp, *surfels[i].surfel.sharp);
    }
    expect_every_damage_is_seen(folder, read_bytes(folder.file("f")),
                                [](const std::string& path) { read_fit(path); });
}

/// some_model with a sharp node 2.
SurfelTreeData some_sharp_model() {
    SurfelTreeData data = some_model();
    std::vector<Surfel> surfels;
    for (std::size_t i = 0; i < data.nodes.size(); ++i) surfels.push_back(data.view().surfel(i));
    surfels[2].sharp = some_sheets(2);
    encode_surfels(surfels, data);
    data.nodes[2].flags |= kSharp;
    return data;
}

TEST(ModelFile, SharpSurfelsRoundTripAndMakeItVersion2) {
    const TempFolder folder;
    write_model(folder.file("smooth"), some_model(), "{}");
    write_model(folder.file("m"), some_sharp_model(), "{}");
    EXPECT_EQ(read_bytes(folder.file("smooth"))[8], 1);
    EXPECT_EQ(read_bytes(folder.file("m"))[8], 2);
    const ModelFile model = ModelFile::open(folder.file("m"));
    const SurfelTree tree = model.tree();
    EXPECT_FALSE(tree.surfel(1).sharp);
    ASSERT_TRUE(tree.surfel(2).sharp);
    expect_equal(*tree.surfel(2).sharp, *some_sheets(2));
    expect_every_damage_is_seen(folder, read_bytes(folder.file("m")),
                                [](const std::string& path) { ModelFile::open(path); });
}

/// A root with planes below it in a file of cubics.
SurfelTreeData some_mixed_model() {
    SurfelTreeData data = some_model();
    std::vector<Surfel> surfels;
    for (std::size_t i = 0; i < data.nodes.size(); ++i) surfels.push_back(data.view().surfel(i));
    data.header.degree = 3;
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        surfels[i].degree = static_cast<int>(i);
        for (std::size_t k = 1; k < kMaxCoefficients; ++k)
            if (k >= static_cast<std::size_t>(n_coefficients(surfels[i].degree)))
                surfels[i].polynomial.a[k] = 0;
        data.nodes[i].degree = static_cast<std::uint8_t>(i);
    }
    encode_surfels(surfels, data);
    return data;
}

TEST(ModelFile, RecordsOfMixedDegreesRoundTripAndMakeItVersion3) {
    const TempFolder folder;
    const SurfelTreeData data = some_mixed_model();
    ASSERT_EQ(data.records.size(), 7u + 7u + 12u);
    write_model(folder.file("m"), data, "{}");
    EXPECT_EQ(read_bytes(folder.file("m"))[8], 3);
    const ModelFile model = ModelFile::open(folder.file("m"));
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(model.tree().surfel(i).center, data.view().surfel(i).center);
        EXPECT_EQ(model.tree().surfel(i).polynomial.a, data.view().surfel(i).polynomial.a);
        EXPECT_EQ(model.tree().surfel(i).degree, static_cast<int>(i));
    }
    expect_every_damage_is_seen(folder, read_bytes(folder.file("m")),
                                [](const std::string& path) { ModelFile::open(path); });
}

TEST(ModelFile, RefusesAnIndexThatIsNone) {
    const TempFolder folder;
    const auto expect = [&](const char* reason, const std::function<void(SurfelTreeData&)>& spoil) {
        SurfelTreeData data = some_mixed_model();
        spoil(data);
        write_model(folder.file("m"), data, "{}");
        const std::string error = error_of([&] { ModelFile::open(folder.file("m")); });
        EXPECT_NE(error.find(reason), std::string::npos) << reason << " in: " << error;
    };
    expect("node 1: record begins at float 8, expected 7", [](auto& d) { d.in_page[1] = 8; });
    expect("record begins at float 10, expected 0", [](auto& d) { d.page_start[0] = 10; });
    expect("2 records in 1 pages", [](auto& d) { d.in_page.pop_back(); });
    expect("3 records in 0 pages", [](auto& d) { d.page_start.clear(); });
    expect("records need 26 floats, found 25", [](auto& d) { d.records.pop_back(); });
    expect("node 2: record begins at float 14, expected 19", [](auto& d) { d.nodes[1].degree = 2; });
    expect("node 1: degree 4", [](auto& d) { d.nodes[1].degree = 4; });
    expect("is not finite",
           [](auto& d) { d.records[20] = std::numeric_limits<float>::infinity(); });
}

TEST(ModelFile, RefusesSheetsThatAreNone) {
    const TempFolder folder;
    const auto expect = [&](const char* reason, const std::function<void(SurfelTreeData&)>& spoil) {
        SurfelTreeData data = some_sharp_model();
        spoil(data);
        write_model(folder.file("m"), data, "{}");
        const std::string error = error_of([&] { ModelFile::open(folder.file("m")); });
        EXPECT_NE(error.find(reason), std::string::npos) << reason << " in: " << error;
    };
    expect("node 9 is not a sharp one", [](auto& d) { d.sharp[0].node = 9; });
    expect("node 1 is not a sharp one", [](auto& d) { d.sharp[0].node = 1; });
    expect("1 nodes are sharp, found 2", [](auto& d) { d.sharp.push_back(d.sharp[0]); });
    expect("0 nodes are sharp, found 1", [](auto& d) { d.nodes[2].flags = kLeaf; });
    expect("1 nodes are sharp, found 0", [](auto& d) { d.sharp.clear(); });
    expect("3 further sheets", [](auto& d) { d.sharp[0].n_extra = 3; });
    expect("0 further sheets", [](auto& d) { d.sharp[0].n_extra = 0; });
    expect("join 2", [](auto& d) { d.sharp[0].outer = 2; });
    expect("first sheet 1", [](auto& d) { d.sharp[0].first_sheet = 1; });
    expect("2 sheets need 16 floats, found 15", [](auto& d) { d.sheets.pop_back(); });
    expect("is no part of a sheet", [](auto& d) { d.sheets[8] = 1.5f; });
    expect("is no part of a sheet",
           [](auto& d) { d.sheets[5] = std::numeric_limits<float>::infinity(); });
}

TEST(ModelFile, RoundTripsThroughTheMappedFile) {
    const TempFolder folder;
    const SurfelTreeData data = some_model();
    write_model(folder.file("m"), data, "{}");
    ModelFile opened = ModelFile::open(folder.file("m"));
    const ModelFile model = std::move(opened);
    EXPECT_EQ(model.provenance_json(), "{}");
    EXPECT_EQ(model.header().origin, data.header.origin);
    EXPECT_EQ(model.header().bounds.hi, data.header.bounds.hi);
    EXPECT_EQ(model.header().mdl_threshold, 0.01);
    EXPECT_EQ(model.header().n_points, 110u);
    const SurfelTree tree = model.tree();
    ASSERT_EQ(tree.n_nodes(), 3u);
    EXPECT_EQ(tree.surfel(2).center, data.view().surfel(2).center);
    EXPECT_EQ(tree.surfel(2).polynomial.a, data.view().surfel(2).polynomial.a);
    EXPECT_TRUE(tree.node(1).is_leaf());
    write_model(folder.file("again"), data, "{}");
    EXPECT_EQ(read_bytes(folder.file("m")), read_bytes(folder.file("again")));
}

TEST(ModelFile, SeesEveryFlippedByteAndEveryTruncation) {
    const TempFolder folder;
    write_model(folder.file("m"), some_model(), "{\"a\": 1}");
    expect_every_damage_is_seen(folder, read_bytes(folder.file("m")),
                                [](const std::string& path) { ModelFile::open(path); });
}

TEST(ModelFile, Row44RefusesTreesThatAreNone) {
    const TempFolder folder;
    const auto refusal = [&](const std::function<void(SurfelTreeData&)>& spoil) {
        SurfelTreeData data = some_model();
        spoil(data);
        write_model(folder.file("m"), data, "{}");
        return error_of([&] { ModelFile::open(folder.file("m")); });
    };
    const auto expect = [&](const char* reason, const std::function<void(SurfelTreeData&)>& spoil) {
        const std::string error = refusal(spoil);
        EXPECT_NE(error.find(reason), std::string::npos) << reason << " in: " << error;
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(refusal([](SurfelTreeData&) {}), "");
    expect("node 0: children up to 4", [](auto& d) { d.nodes[0].n_children = 3; });
    expect("children up to", [](auto& d) { d.nodes[0].n_children = 0xffffffffu; });
    expect("node 2: has no parent", [](auto& d) { d.nodes[0].n_children = 1; });
    expect("does not follow its parent", [](auto& d) { d.nodes[0].first_child = 0; });
    expect("node 2: child 1", [](auto& d) { d.nodes[2].first_child = 1, d.nodes[2].n_children = 1; });
    expect("has another parent", [](auto& d) { d.nodes[1].first_child = 2, d.nodes[1].n_children = 1; });
    expect("is not finite", [&](auto& d) { d.records[12] = nan; });
    expect("support radius 0", [](auto& d) { d.records[12 + 3] = 0; });
    expect("node 0: bound radius 1 does not hold the ball of child 1", [](auto& d) {
        d.nodes[0].bound_radius = 1, d.records[3] = 1;
    });
    expect("node 1: bound radius", [](auto& d) { d.nodes[1].bound_radius = 0.25f; });
    expect("bound radius", [&](auto& d) { d.nodes[1].bound_radius = nan; });
    expect("level 65", [](auto& d) { d.nodes[1].level = 65; });
    expect("degree 3 is above", [](auto& d) { d.nodes[1].degree = 3; });
    expect("says 3 leaves, found 2", [](auto& d) { d.header.n_leaves = 3; });
    expect("degree 4", [](auto& d) { d.header.degree = 4; });
    expect("need 2 pages", [](auto& d) {
        d.nodes.resize(1025);
        d.records.resize(1025 * 12);
    });
    expect("floats of records", [](auto& d) { d.records.pop_back(); });
    expect("found no node", [](auto& d) { d.nodes.clear(), d.records.clear(), d.page_origins.clear(); });
}

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
        EXPECT_EQ(source->info().skipped,
                  (std::vector<std::string>{"red", "green", "blue", "scalar_k1", "quality"}));
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
    EXPECT_EQ(truth_path("a/cloud.ply"), "a/cloud.truth");
    EXPECT_EQ(truth_path("a/cloud.xyz.gz"), "a/cloud.truth");
}

}  // namespace
}  // namespace slim::test
