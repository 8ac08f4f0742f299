#include "formats/model_file.h"
#include "pipeline/child_process.h"
#include "pipeline/render_stage.h"
#include "slim/base/hash.h"
#include "tests/pipeline/fit_stages_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

// NUMERICS section 6: the rows that need stages. The others are in tests/slim/extremes,
// tests/slim/cover, tests/slim/fit and tests/formats: `grep -r RowNN tests` finds each.

namespace slim::test {
namespace {

namespace fs = std::filesystem;

class Extremes : public FitStages {
protected:
    nlohmann::json built(const std::string& cloud, const std::string& model = "m.slim") {
        return build(build_config(cloud, model));
    }
    static nlohmann::json fit_of(const nlohmann::json& result) {
        return result.at("stages").at("fit");
    }
    bool warned_of(const std::string& text) const {
        return std::any_of(listener_.warnings.begin(), listener_.warnings.end(),
                           [&](const auto& w) { return w.find(text) != std::string::npos; });
    }
    std::string write_text(const std::string& name, const std::vector<Vec3d>& points) const {
        std::string text;
        for (const Vec3d& p : points) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
        return folder_.write(name, text);
    }
    std::string write_floats(const std::string& name, const Cloud& cloud) const {
        PlyLayout layout;
        layout.normals = true;
        PlyWriter writer(file(name), layout);
        writer.write({cloud.positions, cloud.normals, {}, {}, {}});
        writer.commit();
        return file(name);
    }
};

/// Every number of a model is the other's times the power of its unit, bit for bit.
void expect_scaled(const ModelFile& one, const ModelFile& other, double scale) {
    const SurfelTree a = one.tree(), b = other.tree();
    ASSERT_EQ(a.n_nodes(), b.n_nodes());
    EXPECT_EQ(b.header().noise_variance, a.header().noise_variance * scale * scale);
    EXPECT_EQ(b.header().diagonal, a.header().diagonal * scale);
    for (std::size_t i = 0; i < a.page_origins().size(); ++i)
        ASSERT_EQ(b.page_origins()[i], a.page_origins()[i] * scale);
    const auto s = static_cast<float>(scale);
    for (std::size_t i = 0; i < a.n_nodes(); ++i) {
        const TreeNode &m = a.node(i), &n = b.node(i);
        ASSERT_EQ(m.first_child, n.first_child);
        ASSERT_EQ(m.n_children, n.n_children);
        ASSERT_EQ(m.flags, n.flags);
        ASSERT_EQ(m.level, n.level);
        ASSERT_EQ(m.n_points, n.n_points);
        ASSERT_EQ(m.fit_error * s, n.fit_error);
        ASSERT_EQ(m.bound_radius * s, n.bound_radius);
        ASSERT_EQ(a.record_degree(i), b.record_degree(i));
        const auto size = static_cast<std::size_t>(floats_per_surfel(a.record_degree(i)));
        for (std::size_t k = 0; k < size;
             ++k)  // centre and radius; normal and coefficients have no unit
            ASSERT_EQ(a.record(i)[k] * (k < 4 ? s : 1.0f), b.record(i)[k]) << "float " << k;
    }
}

TEST_F(Extremes, Row01PowersOfTwoScaleTheWholeModelBitByBit) {
    const Cloud cloud = sampled("bumpy", 10000, 1, 1e-3);
    for (const bool normals : {true, false}) {
        SCOPED_TRACE(normals ? "with normals" : "normals estimated");
        built(write(cloud, "one.ply", normals), "one.slim");
        const ModelFile one = ModelFile::open(file("one.slim"));
        for (const int power : {-30, 30}) {
            SCOPED_TRACE(power);
            const double scale = std::ldexp(1.0, power);
            Cloud scaled = cloud;
            for (Vec3d& p : scaled.positions) p *= scale;
            built(write(scaled, "scaled.ply", normals), "scaled.slim");
            expect_scaled(one, ModelFile::open(file("scaled.slim")), scale);
        }
    }
}

/// A sphere of radius 0.01 with dents of 1e-4, its coordinates multiples of the step of doubles at
/// 1e7.
Cloud detailed() {
    Cloud cloud = sampled("bumpy", 10000);
    for (Vec3d& p : cloud.positions) {
        p *= 0.01;
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = std::round(std::ldexp(p[axis], 29)) * 0x1p-29;
    }
    return cloud;
}

TEST_F(Extremes, Row04ADistantCloudInDoublesIsTheUnshiftedOne) {
    Cloud cloud = detailed();
    built(write(cloud, "near.ply"), "near.slim");
    for (Vec3d& p : cloud.positions) p += Vec3d{1e7, -1e7, 1e7};
    built(write(cloud, "far.ply"), "far.slim");
    const ModelFile far = ModelFile::open(file("far.slim"));
    expect_scaled(ModelFile::open(file("near.slim")), far, 1);
    EXPECT_LT(length(far.header().origin - Vec3d{1e7, -1e7, 1e7}), 0.1);
    EXPECT_FALSE(warned_of("finer detail"));
}

TEST_F(Extremes, Row05TheSameInFloatsWarnsAndFloorsLambdaAtTheQuantum) {
    // Floats at 1e7 step by 1: nothing is left of a cloud of 0.03.
    Cloud cloud = detailed();
    for (Vec3d& p : cloud.positions) p += Vec3d{1e7, -1e7, 1e7};
    const std::string lost = write_floats("lost.ply", cloud);
    EXPECT_EQ(code_of([&] { built(lost); }), ExitCode::bad_data);
    EXPECT_TRUE(warned_of("finer detail"));
    EXPECT_NE(message_.find("lost.ply"), std::string::npos) << message_;

    // Of one of 2,000 much is: lambda is the floor (4 q)^2, for what is below is rounding.
    listener_.warnings.clear();
    Cloud large = sampled("sphere", 20000);
    for (Vec3d& p : large.positions) p = p * 1000.0 + Vec3d{1e7, 0, 0};
    const auto result = built(write_floats("large.ply", large));
    EXPECT_TRUE(warned_of("finer detail"));
    EXPECT_EQ(fit_of(result)["noise_variance"], 16.0);
    EXPECT_TRUE(fit_of(result)["noise_variance_floored"].get<bool>());
    // The model of rounded points is within a quantum of the truth.
    const auto measured = measure(file("m.slim"), write(large, "exact.ply"));
    EXPECT_EQ(measured["missed"], 0);
    EXPECT_LT(measured["l2"].get<double>() * measured["diagonal"].get<double>(), 1);
}

TEST_F(Extremes, Row06AllPointsInOnePlaceAreRefusedWithTheReason) {
    for (const std::size_t n : {2u, 3u, 1000u}) {
        SCOPED_TRACE(n);
        const std::string same = write_text("same.xyz", std::vector<Vec3d>(n, {1, 2, 3}));
        EXPECT_EQ(code_of([&] { built(same); }), ExitCode::bad_data);
        EXPECT_NE(message_.find("same.xyz"), std::string::npos) << message_;
        EXPECT_NE(message_.find("do not coincide"), std::string::npos) << message_;
        EXPECT_NE(message_.find(": " + std::to_string(n) + " points within"), std::string::npos)
            << message_;
    }
    const std::string one = write_text("one.xyz", std::vector<Vec3d>(1, {1, 2, 3}));
    EXPECT_EQ(code_of([&] { built(one); }), ExitCode::bad_data);
    EXPECT_NE(message_.find(": 1 point within"), std::string::npos) << message_;
    listener_.warnings.clear();
    const std::string floats =
        folder_.write("one.ply",
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n9 8 7\n");
    EXPECT_EQ(code_of([&] { built(floats); }), ExitCode::bad_data);
    EXPECT_FALSE(warned_of("finer detail"));  // there is none
}

TEST_F(Extremes, Row07CopiesOfAFewPointsAreTheUniqueSet) {
    for (const auto& [n, copies] : {std::pair{60, 12}, {150, 6}, {4, 20}}) {
        SCOPED_TRACE(testing::Message() << n << " x " << copies);
        const Cloud cloud = sampled("sphere", static_cast<std::size_t>(n));
        Cloud all;
        for (int i = 0; i < copies; ++i) append(all, cloud);
        build(build_config(write(cloud, "once.ply"), "once.slim"));
        const auto result = build(build_config(write(all, "often.ply"), "often.slim"));
        EXPECT_EQ(result.at("stages").at("fit").at("copies"),
                  static_cast<std::uint64_t>(n * (copies - 1)));
        const auto once = measure(file("once.slim"), file("once.ply"));
        const auto often = measure(file("often.slim"), file("once.ply"));
        EXPECT_EQ(often.at("leaves"), once.at("leaves"));
        EXPECT_EQ(often.at("missed"), once.at("missed"));
        EXPECT_NEAR(often.at("l2").get<double>(), once.at("l2").get<double>(),
                    0.02 * once.at("l2").get<double>());
    }
}

TEST_F(Extremes, Row08OneOrTwoScanLinesMakeDiscsAndPlanesAndSaySo) {
    for (const int lines : {1, 2}) {
        SCOPED_TRACE(lines);
        std::vector<Vec3d> points;
        for (int i = 0; i < 600; ++i)
            points.push_back({i / 300.0, 0.05 * (i % lines), 0.3 * i / 600});
        const auto fit = fit_of(built(write_text("lines.xyz", points)));
        const std::uint64_t leaves = fit["leaves"];
        EXPECT_GT(leaves, 0u);
        EXPECT_EQ(
            fit["degrees"]["0"].get<std::uint64_t>() + fit["degrees"]["1"].get<std::uint64_t>(),
            leaves);
        std::uint64_t causes = 0;
        for (const auto& [cause, count] : fit["fallbacks"].items())
            causes += count.get<std::uint64_t>();
        // A forced leaf takes the lowest degree that explains it: that is no fallback.
        EXPECT_GE(causes + fit["forced"].get<std::uint64_t>(), leaves);
    }
}

TEST_F(Extremes, Row21AThinSheetWithoutNormalsBecomesOneSurfaceHalfway) {
    // Two layers 0.3 spacings apart, points in either at random. Without normals nothing tells them
    // from one noisy sheet: that is the documented failure. (The row asks for a warning as well;
    // there is none yet.) With normals they stay two:
    // LevelCover.Row20AThinSheetsLeavesStayOnTheirSide.
    constexpr double gap = 0.3 * 2 / 100;  // 10,000 points a layer over [-1, 1]^2
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < 20000; ++i)
        points.push_back({2 * unit_interval(keyed_hash(1, i)) - 1,
                          2 * unit_interval(keyed_hash(2, i)) - 1,
                          i % 2 == 0 ? gap / 2 : -gap / 2});
    const std::string cloud = write_text("sheet.xyz", points);
    const auto result = built(cloud);
    const auto m = measure(file("m.slim"), cloud);
    EXPECT_EQ(m["missed"], 0);
    const double half = m["l2"].get<double>() * m["diagonal"].get<double>();
    EXPECT_NEAR(half / (gap / 2), 1, 0.05);
    EXPECT_LT(m["max"].get<double>() * m["diagonal"].get<double>(), gap);
    // lambda takes the gap for noise: 0.7 (gap / 2)^2 of ten neighbours less a plane's freedom.
    EXPECT_NEAR(result["noise_variance"].get<double>() / (gap * gap / 4), 0.65, 0.2);
}

TEST_F(Extremes, Row27UpToATenthOfFlippedNormalsDoNoHarmMoreAreEstimatedAnew) {
    const Cloud clean = sampled("sphere", 20000);
    const std::string truth = write(clean, "truth.ply");
    built(truth, "clean.slim");
    const auto reference = measure(file("clean.slim"), truth);
    for (const double share : {0.01, 0.05, 0.09, 0.2, 0.35, 0.5}) {
        SCOPED_TRACE(share);
        listener_.warnings.clear();
        Cloud flipped = clean;
        for (std::size_t i = 0; i < clean.size(); ++i)
            if (unit_interval(keyed_hash(1, i)) < share) flipped.normals[i] = -flipped.normals[i];
        const auto result = built(write(flipped, "flipped.ply"));
        const bool many = share > 0.1;
        EXPECT_EQ(warned_of("estimated anew"), many);
        EXPECT_EQ(result["normals_estimated"].get<std::uint64_t>(), many ? 20000u : 0u);
        if (!many) {
            EXPECT_NEAR(result["normals_turned"].get<double>(), share * 20000,
                        0.1 * share * 20000 + 10);
        }
        const auto m = measure(file("m.slim"), truth);
        EXPECT_EQ(m["missed"], 0);
        EXPECT_EQ(m["opposed"], 0);  // against the truth: no side is turned
        EXPECT_NEAR(m["leaves"].get<double>() / reference["leaves"].get<double>(), 1, 0.1);
        EXPECT_LT(m["l2"].get<double>(), 1.5 * reference["l2"].get<double>());
    }
}

TEST_F(Extremes, Row28ZeroNormalsAreEstimatedAndCounted) {
    Cloud cloud = sampled("sphere", 10000);
    const std::string truth = write(cloud, "truth.ply");
    std::size_t zeros = 0;
    for (std::size_t i = 0; i < cloud.size(); i += 3, ++zeros) cloud.normals[i] = {};
    const auto result = built(write(cloud, "zeros.ply"));
    EXPECT_EQ(result["normals_estimated"], zeros);
    EXPECT_EQ(result["stages"]["normals"]["kept"], 10000 - zeros);
    const auto m = measure(file("m.slim"), truth);
    EXPECT_EQ(m["missed"], 0);
    EXPECT_EQ(m["opposed"], 0);
}

TEST_F(Extremes, Row29NonFinitePointsAreDroppedAndCountedOrRefused) {
    Cloud cloud = sampled("sphere", 5000);
    built(write(cloud, "clean.ply"), "clean.slim");
    cloud.positions[100].x = NAN, cloud.positions[2000].y = INFINITY,
    cloud.positions[4999].z = -INFINITY;
    BuildConfig config = build_config(write(cloud, "bad.ply"), "m.slim");
    const auto result = build(config);
    EXPECT_EQ(result["stages"]["slice"]["dropped"], 3);
    EXPECT_EQ(result["points"], 4997);
    EXPECT_TRUE(warned_of("3 of 5000 points are not finite"));
    EXPECT_NEAR(result["leaves"].get<double>() /
                    static_cast<double>(ModelFile::open(file("clean.slim")).header().n_leaves),
                1, 0.1);
    config.strict = true;
    EXPECT_EQ(code_of([&] { build(config); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("bad.ply: point 101"), std::string::npos) << message_;
}

TEST_F(Extremes, Row30NoPointsAreRefusedWithTheFile) {
    for (const char* text : {"# only a comment\n", "nan nan nan\n", ""}) {
        const std::string empty = folder_.write("empty.xyz", text);
        EXPECT_EQ(code_of([&] { built(empty); }), ExitCode::bad_data);
        EXPECT_NE(message_.find("empty.xyz"), std::string::npos) << message_;
        EXPECT_FALSE(fs::exists(file("m.slim")));
    }
}

TEST_F(Extremes, Row31AFewPointsMakeAModelThatRenders) {
    const std::vector<Vec3d> points{{0, 0, 0},   {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {0, 1, 0},
                                    {1, 1, 0.1}, {2, 1, 0}, {1, 2, 0}, {2, 2, 0}};
    for (const std::size_t n : {1u, 2u, 3u, 9u}) {
        SCOPED_TRACE(n);
        const std::string cloud =
            write_text("few.xyz", {points.begin(), points.begin() + static_cast<long>(n)});
        if (n < 3) {  // no surface: the other outcome that the row's sense allows
            EXPECT_EQ(code_of([&] { built(cloud); }), ExitCode::bad_data);
            EXPECT_NE(message_.find("at least 3 points"), std::string::npos) << message_;
            continue;
        }
        const auto result = built(cloud);
        EXPECT_EQ(fit_of(result)["degrees"]["2"], 0);
        RenderConfig render;
        render.model = file("m.slim");
        render.output = file("few.png");
        render.size = "64x64";
        render.camera = "front";  // along -z
        const auto drawn =
            run_as("render", render, run_render, listener_);  // throws if nothing is hit
        EXPECT_TRUE(fs::exists(file("few.png"))) << drawn.dump();
    }
}

TEST_F(Extremes, Row32HugeAndDenormalCoordinatesAreRefusedWithTheirBox) {
    const auto refusal = [&](double scale) {
        std::vector<Vec3d> points;
        for (const Vec3d& p : sampled("sphere", 50).positions) points.push_back(p * scale);
        const std::string cloud = write_text("extreme.xyz", points);
        EXPECT_EQ(code_of([&] { built(cloud); }), ExitCode::bad_data) << scale;
        EXPECT_NE(message_.find("extreme.xyz"), std::string::npos) << message_;
        return message_;
    };
    for (const double huge : {1e200, 1e308}) {  // the square of 1e200 is no double
        EXPECT_NE(refusal(huge).find("overflows"), std::string::npos);
        EXPECT_NE(message_.find("from ("), std::string::npos) << message_;
    }
    for (const double scale : {1e100, 1e-100})
        EXPECT_NE(refusal(scale).find("the cloud's diagonal is"), std::string::npos);
    EXPECT_NE(refusal(1e-310).find("change its unit"), std::string::npos)
        << message_;  // its square is none
    // A denormal coordinate beside ordinary ones is as good as zero.
    Cloud cloud = sampled("plane", 2000);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        cloud.positions[i].z = i % 2 == 0 ? 4e-320 : -4e-320;
    EXPECT_GT(built(write(cloud, "plane.ply"))["leaves"].get<int>(), 0);
}

TEST_F(Extremes, Row33MorePointsThanMemoryStayBelowTheCap) {
    const std::string bin = SLIM_BIN_DIR;
    ASSERT_EQ(run_child({bin + "/slim-scan", "sphere", "-o", file("big.ply"), "--points", "600000",
                         "--pattern", "uniform", "-q"})
                  .exit_code,
              0);
    // As the build says, of itself: what the system says of a child holds its parent's pages too.
    const auto peak = [&](const std::string& memory) {
        const ChildResult run =
            run_child({bin + "/slim-build", file("big.ply"), "-o", file("big.slim"), "--memory",
                       memory, "--force", "-q", "--json"});
        EXPECT_EQ(run.exit_code, 0);
        const auto result = nlohmann::json::parse(run.output);
        EXPECT_EQ(result.at("points"), 600000);
        return result.at("peak_memory_bytes").get<double>() / (1 << 20);
    };
    EXPECT_GT(peak("1GiB"), 1.1 * 64);  // so the cap below is one
    EXPECT_LE(peak("64MiB"), 1.1 * 64);
}

TEST_F(Extremes, Row35AnExactPlaneHasAFlooredLambdaAndSaturatedLeaves) {
    Cloud plane = sampled("plane", 10000);
    for (Vec3d& p : plane.positions) p.z = 0;
    const auto fit = fit_of(built(write(plane, "plane.ply")));
    EXPECT_TRUE(fit["noise_variance_floored"].get<bool>());
    EXPECT_GT(fit["noise_variance"].get<double>(), 0);
    EXPECT_EQ(fit["saturated"], fit["leaves"]);
    EXPECT_LT(measure(file("m.slim"), file("plane.ply"))["max"].get<double>(),
              1e-7);  // stored as floats
}

}  // namespace
}  // namespace slim::test
