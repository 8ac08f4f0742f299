#include "formats/slice_file.h"

#include "slim/base/parallel.h"
#include "tests/formats/file_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <unistd.h>

// Selections of slices of several pieces, against the points one by one.

namespace slim::test {
namespace {

constexpr std::size_t kPoints = 30000;  // eight pieces

/// A helix, with ids that do not begin at 0 and leave gaps.
PointBlock helix(bool scans) {
    PointBlock block;
    block.origin = {100, -200, 0.25};
    for (std::size_t i = 0; i < kPoints; ++i) {
        const double t = static_cast<double>(i) / 1000;
        block.position.push_back({std::cos(t), std::sin(t), t});
        block.normal.push_back(
            {static_cast<float>(std::cos(t)), static_cast<float>(std::sin(t)), 0});
        block.id.push_back(1000 + 3 * i);
        if (scans) block.scan.push_back(static_cast<std::uint16_t>(i / 7000));
    }
    return block;
}

using IsWanted = std::function<bool(const PointBlock&, std::size_t)>;

void expect_chosen(const PointBlock& got, const PointBlock& of, const IsWanted& is_wanted) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < of.size(); ++i) {
        if (!is_wanted(of, i)) continue;
        ASSERT_LT(n, got.size());
        ASSERT_EQ(got.id[n], of.id[i]);
        ASSERT_EQ(got.position[n], of.position[i]);
        ASSERT_EQ(got.normal[n], of.normal[i]);
        ASSERT_EQ(got.has_scans(), of.has_scans());
        if (of.has_scans()) {
            ASSERT_EQ(got.scan[n], of.scan[i]);
        }
        ++n;
    }
    EXPECT_EQ(got.size(), n);
}

/// What a half space wants of a box.
WantedOf beyond(const Bbox& box, double x) {
    return box.lo.x >= x ? WantedOf::all : box.hi.x < x ? WantedOf::none : WantedOf::some;
}

/// Addresses that this process has in use, as `ulimit -v` counts them.
std::size_t address_space() {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST(SliceSelection, OpenSlicesTakeNoAddresses) {
    const TempFolder folder;
    const std::string path = folder.file("s");
    write_slice(path, helix(true));
    const auto file_size = static_cast<std::size_t>(std::filesystem::file_size(path));
    ASSERT_GT(file_size, 800'000u);
    std::vector<SliceSelection> halos(20);
    const std::size_t before = address_space();
    for (SliceSelection& halo : halos)
        halo.add(
            path, [](const Bbox&) { return WantedOf::none; }, [](const Vec3d&) { return false; });
    EXPECT_LT(address_space(), before + 5 * file_size);
}

TEST(SliceSelection, TakesTheWantedPointsOfEveryPieceInTheirOrder) {
    const TempFolder folder;
    for (const bool scans : {false, true}) {
        SCOPED_TRACE(scans);
        const PointBlock block = helix(scans);
        const std::string path = folder.file("s");
        write_slice(path, block);
        SliceSelection by_place, by_id, whole;
        by_place.add(
            path, [](const Bbox& box) { return beyond(box, 0.3); },
            [](const Vec3d& p) { return p.x >= 0.3; });
        by_id.add(path, [](std::uint64_t id) { return id % 5 == 0; });
        whole.add(path);
        PointBlock places, ids, all;
        by_place.append_to(places), by_id.append_to(ids), whole.append_to(all);
        expect_chosen(places, block,
                      [](const PointBlock& b, std::size_t i) { return b.position[i].x >= 0.3; });
        expect_chosen(ids, block,
                      [](const PointBlock& b, std::size_t i) { return b.id[i] % 5 == 0; });
        expect_chosen(all, block, [](const PointBlock&, std::size_t) { return true; });
        EXPECT_EQ(places.origin, block.origin);
    }
}

// Nobody is asked of points whose box says it; those asked are of the pieces that say `some`.
TEST(SliceSelection, AsksOfPointsOnlyWhereTheBoxDoesNotSay) {
    const TempFolder folder;
    const PointBlock block = helix(false);
    write_slice(folder.file("s"), block);
    const ThreadLimit limit(1);
    std::vector<Bbox> asked;
    std::size_t n_all = 0, n_none = 0, n_points = 0;
    SliceSelection chosen;
    chosen.add(
        folder.file("s"),
        [&](const Bbox& box) {
            asked.push_back(box);
            const WantedOf wanted = box.hi.z < 10   ? WantedOf::none
                                    : box.lo.z > 20 ? WantedOf::all
                                                    : WantedOf::some;
            n_all += wanted == WantedOf::all, n_none += wanted == WantedOf::none;
            return wanted;
        },
        [&](const Vec3d& p) {
            ++n_points;
            return p.z >= 10;
        });
    PointBlock out;
    chosen.append_to(out);
    EXPECT_GE(asked.size(), 7u);
    EXPECT_GE(n_all, 2u);
    EXPECT_GE(n_none, 2u);
    EXPECT_LT(n_points, kPoints * 2 / 3);
    expect_chosen(out, block,
                  [](const PointBlock& b, std::size_t i) { return b.position[i].z >= 10; });
}

TEST(SliceSelection, OfSeveralSlicesIsSliceAfterSliceForAnyNumberOfThreads) {
    const TempFolder folder;
    const PointBlock block = helix(true);
    PointBlock twice = block;
    for (std::uint64_t& id : twice.id) id += 1000000;
    write_slice(folder.file("a"), block);
    write_slice(folder.file("b"), twice);
    for (const int n : {1, 3}) {
        const ThreadLimit limit(n);
        SliceSelection chosen;
        chosen.add(folder.file("b"), [](std::uint64_t id) { return id % 2 == 0; });
        chosen.add(folder.file("a"));
        chosen.add(
            folder.file("b"), [](const Bbox& box) { return beyond(box, 0.9); },
            [](const Vec3d& p) { return p.x >= 0.9; });
        PointBlock out;
        chosen.append_to(out);
        chosen.append_to(out);  // a selection may be read again, behind what is there
        PointBlock expected;
        for (int k = 0; k < 2; ++k) {
            const auto take = [&](const PointBlock& of, const IsWanted& is_wanted) {
                for (std::size_t i = 0; i < of.size(); ++i) {
                    if (!is_wanted(of, i)) continue;
                    expected.position.push_back(of.position[i]);
                    expected.normal.push_back(of.normal[i]);
                    expected.id.push_back(of.id[i]);
                    expected.scan.push_back(of.scan[i]);
                }
            };
            take(twice, [](const PointBlock& b, std::size_t i) { return b.id[i] % 2 == 0; });
            take(block, [](const PointBlock&, std::size_t) { return true; });
            take(twice, [](const PointBlock& b, std::size_t i) { return b.position[i].x >= 0.9; });
        }
        EXPECT_EQ(out.id, expected.id);
        EXPECT_EQ(out.position, expected.position);
        EXPECT_EQ(out.normal, expected.normal);
        EXPECT_EQ(out.scan, expected.scan);
    }
}

TEST(SliceSelection, OfNothingWantedLeavesThePointsAsTheyAre) {
    const TempFolder folder;
    const PointBlock block = helix(false);
    write_slice(folder.file("s"), block);
    SliceSelection chosen;
    chosen.add(folder.file("s"), [](std::uint64_t) { return false; });
    chosen.add(
        folder.file("s"), [](const Bbox&) { return WantedOf::none; },
        [](const Vec3d&) { return true; });
    PointBlock out = block;
    chosen.append_to(out);
    EXPECT_EQ(out.id, block.id);
}

}  // namespace
}  // namespace slim::test
