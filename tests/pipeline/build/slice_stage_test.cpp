#include "pipeline/build/slice_stage.h"

#include "pipeline/build/cloud_survey.h"

#include "pipeline/manifest.h"
#include "tests/formats/format_support.h"

#include "formats/ply_writer.h"
#include "formats/slice_file.h"
#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/slicing/block_plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

std::vector<Vec3d> random_points(std::uint64_t seed, std::size_t n, const Vec3d& shift) {
    std::vector<Vec3d> points(n);
    for (std::size_t i = 0; i < n; ++i)
        points[i] = shift + Vec3d{unit_interval(keyed_hash(seed, i, 0)) * 3,
                                  unit_interval(keyed_hash(seed, i, 1)),
                                  unit_interval(keyed_hash(seed, i, 2))};
    return points;
}

std::string write_cloud(const TempFolder& folder, const std::string& name,
                        const std::vector<Vec3d>& points, bool with_scan = false) {
    PlyLayout layout;
    layout.double_positions = true;
    layout.normals = with_scan;
    layout.scan = with_scan;
    PlyWriter writer(folder.file(name), layout);
    const std::vector<Vec3f> normals(points.size(), Vec3f{0, 0, 1});
    const std::vector<std::uint16_t> scans(points.size(), 3);
    writer.write({points, normals, {}, scans, {}});
    writer.commit();
    return folder.file(name);
}

TEST(CloudSpread, TellsALineFromASpeckBesideStrays) {
    for (const std::size_t n : {std::size_t{12}, std::size_t{2000}, std::size_t{50000}}) {
        SCOPED_TRACE(n);
        CloudSpread line, speck, flat, bent;
        for (std::size_t i = 0; i < n; ++i) {
            const double t = unit_interval(keyed_hash(1, i, 0)),
                         u = unit_interval(keyed_hash(1, i, 1));
            line.add({t, 2 * t, 5 - t});
            speck.add({t, u, t * u});
            flat.add({t, u, 0});
            bent.add({t, 1e-3 * t * t, 0});
        }
        speck.add({1e9, 0, 0});
        EXPECT_TRUE(line.is_line());
        EXPECT_FALSE(line.has_far_strays());
        EXPECT_FALSE(speck.is_line());
        EXPECT_TRUE(speck.has_far_strays());
        for (const CloudSpread& surface : {flat, bent}) {
            EXPECT_FALSE(surface.is_line());
            EXPECT_FALSE(surface.has_far_strays());
        }
    }
}

SlicePlan slice(SliceConfig config) {
    Reporter silent;
    const StageContext parent{silent, 1, false, "", "", "", ""};
    StageContext context = for_stage(parent, "slice", config);
    run_slice(config, context);
    return read_plan(config.work);
}

std::string slicing_error(const SliceConfig& config) {
    try {
        slice(config);
        return {};
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::bad_data);
        return error.what();
    }
}

Bbox shrunk(Bbox box, double width) {
    for (std::size_t axis = 0; axis < 3; ++axis) box.lo[axis] += width, box.hi[axis] -= width;
    return box;
}

/// Whether ids rise among the points in a box, and among the others, which stand in pieces apart.
bool is_in_order(const PointBlock& block, const Bbox& inside) {
    std::vector<std::uint64_t> of_inside, of_others;
    for (std::size_t i = 0; i < block.size(); ++i)
        (is_in(inside, block.position[i]) ? of_inside : of_others).push_back(block.id[i]);
    return std::is_sorted(of_inside.begin(), of_inside.end()) &&
           std::is_sorted(of_others.begin(), of_others.end());
}

TEST(SliceStage, EveryPointStandsInTheSliceOfItsRegionOnceInOrder) {
    const TempFolder folder;
    const std::vector<Vec3d> points = random_points(1, 20000, {-1, 0, 0});
    const SlicePlan plan =
        slice({{write_cloud(folder, "a.ply", points)}, folder.file("work"), "1GiB", 4, false});
    ASSERT_EQ(plan.slices.size(), 4u);
    EXPECT_EQ(plan.origin, (Vec3d{0, 0, 0}));
    std::vector<int> seen(points.size());
    for (std::size_t s = 0; s < 4; ++s) {
        const PointBlock block = read_slice(slice_points_path(folder.file("work"), s).string());
        ASSERT_EQ(block.size(), plan.slices[s].n_points);
        EXPECT_NEAR(static_cast<double>(block.size()), 5000, 50);
        EXPECT_TRUE(is_in_order(block, shrunk(plan.slices[s].region, rim_width(plan))));
        Bbox box;
        for (std::size_t i = 0; i < block.size(); ++i) {
            ++seen[block.id[i]];
            box.extend(block.position[i]);
            ASSERT_EQ(block.position[i], points[block.id[i]]);
            for (std::size_t other = 0; other < 4; ++other)
                ASSERT_EQ(is_in(plan.slices[other].region, block.position[i]), other == s);
        }
        EXPECT_EQ(box.lo, plan.slices[s].bounds.lo);
        EXPECT_EQ(box.hi, plan.slices[s].bounds.hi);
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), 20000);
}

TEST(SliceStage, MemoryDecidesTheNumberOfSlicesAndFewerSlicesLeaveNoOldOnes) {
    const TempFolder folder;
    SliceConfig config{{write_cloud(folder, "a.ply", random_points(2, 5000, {}))},
                       folder.file("work"), "16856KiB", 0, false};
    // Half of the points fit; blocks of them leave room for a halo.
    const std::size_t n = slice(config).slices.size();
    EXPECT_GT(n, 2u);
    EXPECT_LE(n, 16u);
    EXPECT_TRUE(fs::exists(slice_folder(config.work, n - 1)));
    config.memory = "1GiB";
    EXPECT_EQ(slice(config).slices.size(), 1u);
    EXPECT_FALSE(fs::exists(slice_folder(config.work, 1)));
}

TEST(SliceStage, ADistantCloudGetsAnOriginThatLosesNothing) {
    const TempFolder folder;
    const std::vector<Vec3d> points = random_points(3, 1000, {403000, 3604900, -1000});
    const SlicePlan plan =
        slice({{write_cloud(folder, "a.ply", points)}, folder.file("work"), "1GiB", 2, false});
    EXPECT_NE(plan.origin, (Vec3d{0, 0, 0}));
    EXPECT_LE(std::abs(plan.bounds.center().x), plan.diagonal);
    for (std::size_t s = 0; s < plan.slices.size(); ++s) {
        const PointBlock block = read_slice(slice_points_path(folder.file("work"), s).string());
        EXPECT_EQ(block.origin, plan.origin);
        for (std::size_t i = 0; i < block.size(); ++i)
            ASSERT_EQ(block.position[i] + plan.origin, points[block.id[i]]);
    }
}

TEST(SliceStage, IdsCountAllPointsOfAllInputsAndScansStayApart) {
    const TempFolder folder;
    const std::string first = write_cloud(folder, "a.ply", random_points(4, 10, {}), true);
    const std::string second = folder.write("b.xyz", "0 0 0\nnan 0 0\n1 1 1\n");
    const std::string third = write_cloud(folder, "c.ply", random_points(5, 5, {}), true);
    const SlicePlan plan = slice({{first, second, third}, folder.file("work"), "1GiB", 0, false});
    EXPECT_EQ(plan.n_points, 17u);
    EXPECT_EQ(plan.n_dropped, 1u);
    EXPECT_EQ(plan.inputs[1].n_dropped, 1u);
    EXPECT_EQ(plan.inputs[2].first_id, 13u);
    const PointBlock block = read_slice(slice_points_path(folder.file("work"), 0).string());
    ASSERT_EQ(block.size(), 17u);
    EXPECT_EQ(block.id[10], 10u);
    EXPECT_EQ(block.id[11], 12u);
    EXPECT_EQ(block.id[12], 13u);
    EXPECT_EQ(block.scan[9], 3);
    EXPECT_EQ(block.scan[10], 4);
    EXPECT_EQ(block.scan[12], 5 + 3);
    EXPECT_EQ(block.normal[9], (Vec3f{0, 0, 1}));
    EXPECT_EQ(block.normal[10], (Vec3f{0, 0, 0}));
}

TEST(SliceStage, PointsReadOnceAndTwiceAreTheSame) {
    const TempFolder folder;
    const Vec3d far{403000, 3604900, -1000};
    const std::vector<std::string> inputs = {
        folder.write("b.xyz", "403000 3604900 -1000\nnan 0 0\n403001 3604901 -1000\n"),
        write_cloud(folder, "a.ply", random_points(4, 70000, far), true),
        write_cloud(folder, "c.ply", random_points(5, 5, far))};
    // One slice; its points fit into the one memory, not into the other.
    SliceConfig config{inputs, folder.file("once"), "1GiB", 1, false};
    const SlicePlan once = slice(config);
    config.work = folder.file("twice");
    config.memory = "17MiB";
    const SlicePlan twice = slice(config);
    // Pieces of a file are as its points came.
    const PointBlock a = read_slice(slice_points_path(folder.file("once"), 0).string());
    const PointBlock b = read_slice(slice_points_path(folder.file("twice"), 0).string());
    EXPECT_TRUE(a.position == b.position && a.id == b.id && a.normal == b.normal &&
                a.scan == b.scan);
    EXPECT_EQ(a.origin, b.origin);
    EXPECT_TRUE(read_bytes(plan_path(folder.file("once")).string()) ==
                read_bytes(plan_path(folder.file("twice")).string()));
    EXPECT_EQ(once.n_points, 70007u);
    EXPECT_EQ(once.slices[0].bounds.lo, twice.slices[0].bounds.lo);
}

TEST(SliceStage, TheSurveyHashesEachFileToItsEndAsItReadsIt) {
    const TempFolder folder;
    const std::string mesh =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const std::vector<std::string> paths = {
        folder.write("none.xyz", "# nothing\n"),
        write_cloud(folder, "a.ply", random_points(3, 150001, {})),  // of three chunks
        folder.write("b.xyz", "1 2 3\n4 5 6\n\n# the end\n\n"), folder.write("mesh.ply", mesh)};
    std::vector<std::string> hashes;
    for (const std::string& path : paths) hashes.push_back(hash_file(path));
    Reporter silent;
    for (const int threads : {1, 2}) {
        const ThreadLimit limit(threads);
        for (const std::uint64_t most_gathered : {0u, 1000000u})
            EXPECT_EQ(survey_clouds(paths, false, most_gathered, silent).hashes, hashes);
    }
}

TEST(SliceStage, HandsTheSlicesPointsToTheNextStageOnce) {
    const TempFolder folder;
    const SliceConfig config{{write_cloud(folder, "a.ply", random_points(6, 100, {}))},
                             folder.file("work"), "1GiB", 0, false};
    Reporter silent;
    HandedPoints handed;
    const StageContext parent{silent, 1, false, "", "", "", ""};
    StageContext context = for_stage(parent, "slice", config);
    context.handed = &handed;
    run_slice(config, context);
    const std::string path = slice_points_path(config.work, 0).string();
    const auto points = handed.take(path);
    ASSERT_TRUE(points);
    const PointBlock written = read_slice(path);
    EXPECT_EQ(points->position, written.position);
    EXPECT_EQ(points->id, written.id);
    EXPECT_FALSE(handed.take(path));  // given away
    handed.put(path, written);
    EXPECT_FALSE(handed.take("another"));
    EXPECT_FALSE(handed.take(path));  // nobody asked for it in time
}

TEST(SliceStage, Row05QuantumIsTheStepOfStoredFloats) {
    CloudInfo info;
    const Bbox box{{1000, 0, -1}, {1030, 5, 1}};
    info.coordinates = CoordinateType::float32;
    EXPECT_EQ(coordinate_quantum(info, box), std::nextafter(1030.0f, 2000.0f) - 1030.0f);
    info.origin = Vec3d{1000, 0, 0};
    EXPECT_EQ(coordinate_quantum(info, box), std::nextafter(30.0f, 200.0f) - 30.0f);
    info.coordinates = CoordinateType::integer;
    EXPECT_EQ(coordinate_quantum(info, box), 1);
    info.coordinates = CoordinateType::float64;
    EXPECT_EQ(coordinate_quantum(info, box), 0);
}

TEST(SliceStage, RefusesWhatHoldsNoPointsAndWhatOverflows) {
    const TempFolder folder;
    const auto error_of = [&](const std::string& text, bool strict = false) {
        return slicing_error(
            {{folder.write("a.xyz", text)}, folder.file("work"), "1GiB", 0, strict});
    };
    EXPECT_TRUE(error_of("# nothing\n").ends_with(": no points"));
    EXPECT_NE(error_of("nan 0 0\n0 inf 0\n").find("no points (2 not finite"), std::string::npos);
    EXPECT_NE(error_of("1e308 0 0\n-1e308 0 0\n").find("extent overflows"), std::string::npos);
    EXPECT_NE(error_of("1 2 3\n4 nan 6\n", true).find("point 2: coordinates are not finite"),
              std::string::npos);
    EXPECT_EQ(error_of("1 2 3\n4 nan 6\n", false), "");
    EXPECT_EQ(error_of("1 2 3\n"), "");
}

TEST(SliceStage, DoesNothingWhenItIsUpToDateAndPlansRefuseDamage) {
    const TempFolder folder;
    SliceConfig config{{write_cloud(folder, "a.ply", random_points(6, 100, {}))},
                       folder.file("work"), "1GiB", 0, false};
    slice(config);
    const auto written = fs::last_write_time(plan_path(config.work));
    slice(config);
    EXPECT_EQ(fs::last_write_time(plan_path(config.work)), written);
    std::ofstream(plan_path(config.work)) << "{\"version\": 99}";
    EXPECT_THROW(read_plan(config.work), FormatError);
    std::ofstream(plan_path(config.work)) << "{\"version\": 1}";
    EXPECT_THROW(read_plan(config.work), FormatError);
    std::ofstream(plan_path(config.work)) << "{\"vers";
    EXPECT_THROW(read_plan(config.work), FormatError);
    EXPECT_THROW(read_plan(folder.file("nowhere")), IoError);
    EXPECT_EQ(slice(config).n_points, 100u);
}

TEST(SliceStage, OfTwoFaultsNamesTheFirstInTheFileThoughPointsAreReadAhead) {
    const TempFolder folder;
    std::string text;
    for (int i = 0; i < 140000; ++i) text += i == 9 ? "nan 0 0\n" : "1 2 3\n";
    text += "not a number\n";
    SliceConfig config;
    config.inputs = {folder.write("two.xyz", text)};
    config.work = folder.file("work");
    config.strict = true;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        EXPECT_NE(slicing_error(config).find("point 10: coordinates are not finite"),
                  std::string::npos);
    }
    config.strict = false;
    EXPECT_NE(slicing_error(config).find("line 140001"), std::string::npos);
}

}  // namespace
}  // namespace slim::test
