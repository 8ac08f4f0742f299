#include "formats/model_file.h"
#include "pipeline/child_process.h"
#include "raytrace/lines/extract.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/frame.h"
#include "tests/pipeline/build/fit_stages_support.h"
#include "tests/pipeline/extremes_support.h"
#include "tests/slim/fit/fit_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

// NUMERICS section 6: the rows that need stages. The others are in tests/slim/extremes,
// tests/slim/cover, tests/slim/fit and tests/formats: `grep -r RowNN tests` finds each.

namespace slim::test {
namespace {

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

// T is a share of the box's diagonal, which turns with the axes (3.52 and 3.64 here).
TEST_F(Extremes, Row03ATurnedCloudHasAsManyLeavesByTheCommand) {
    const Cloud cloud = sampled("bumpy", 30000);
    const double leaves = built(write(cloud, "upright.ply"), "upright.slim")["leaves"];
    const double l2 = measure(file("upright.slim"), file("upright.ply"))["l2"];
    for (std::uint64_t i = 0; i < 2; ++i) {
        SCOPED_TRACE(i);
        const Frame<double> turn = frame_from_normal(random_direction(5, i));
        Cloud turned = cloud;
        for (std::size_t k = 0; k < cloud.size(); ++k) {
            turned.positions[k] = turn.local_from_world(cloud.positions[k]);
            turned.normals[k] = to_float(turn.local_from_world(to_double(cloud.normals[k])));
            turned.truth[k].normal = turn.local_from_world(cloud.truth[k].normal);
        }
        const auto result = built(write(turned, "turned.ply"));
        EXPECT_NEAR(result["leaves"].get<double>() / leaves, 1, 0.03);
        const auto m = measure(file("m.slim"), file("turned.ply"));
        EXPECT_EQ(m["missed"], 0);
        EXPECT_NEAR(m["l2"].get<double>() / l2, 1, 0.1);
    }
}

TEST_F(Extremes, Row13ACyclideModelHasNoCrestLines) {
    BuildConfig config = build_config(write(sampled("cyclide", 40000), "cyclide.ply"), "m.slim");
    config.degree = "3";
    build(config);
    const ModelFile model = ModelFile::open(file("m.slim"));
    const std::vector<LineKind> kinds{LineKind::valley, LineKind::ridge};
    for (const char* camera : {"top", "front", "iso"}) {
        SCOPED_TRACE(camera);
        RenderRequest request;
        request.camera =
            named_camera(camera, model.tree().header().bounds, 1, {.up = UpAxis::z});
        request.width = request.height = 300;
        request.wanted = line_channels(kinds, 3);
        request.lod_px = 0;
        GBuffer out;
        ASSERT_GT(render_forward(model.tree(), request, out).covered_pixels, 5000u);
        const PixelView view = pixel_view(request.camera, 300, 300);
        EXPECT_TRUE(
            extract_lines({out, view, model.tree().header().diagonal, 3}, kinds).empty());
    }
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
    EXPECT_TRUE(warned_of("at one place; if they differ by less than the coordinates' step of 1,"));
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

TEST_F(Extremes, Row35ATiltedPlaneInDoublesToo) {
    const Frame<double> frame = frame_from_normal(normalized(Vec3d{0.3, -0.5, 0.7}));
    Cloud plane = sampled("plane", 10000);
    for (std::size_t i = 0; i < plane.size(); ++i) {
        Vec3d& p = plane.positions[i];
        p.z = 0;
        p = frame.world_from_local(p);
        plane.normals[i] = to_float(frame.normal);
        plane.truth[i].normal = frame.normal;
    }
    const std::string cloud = write(plane, "tilted.ply");
    for (const char* rule : {"ladder", "windows"})
        for (const char* degree : {"1", "2", "3", "auto"}) {
            if (rule == std::string("windows") && degree == std::string("auto")) continue;
            SCOPED_TRACE(testing::Message() << rule << ", degree " << degree);
            BuildConfig config = build_config(cloud, "m.slim");
            config.radius_rule = rule, config.degree = degree;
            const auto fit = fit_of(build(config));
            EXPECT_TRUE(fit["noise_variance_floored"].get<bool>());
            EXPECT_GT(fit["noise_variance"].get<double>(), 0);
            EXPECT_EQ(fit["saturated"], fit["leaves"]);
            EXPECT_LT(fit["leaves"].get<int>(), 150);
            EXPECT_LT(measure(file("m.slim"), cloud)["max"].get<double>(), 1e-7);  // floats
        }
}

}  // namespace
}  // namespace slim::test
