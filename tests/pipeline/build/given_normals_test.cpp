#include "pipeline/build/normals_stage.h"

#include "formats/slice_file.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>

namespace slim::test {
namespace {

/// Normals that a cloud brings and that are wrong as a whole.
class GivenNormals : public FitStages {
protected:
    PointBlock oriented(std::size_t slice = 0) {
        return read_slice(oriented_points_path(file("work"), slice).string());
    }
    static std::size_t inwards(const PointBlock& block) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < block.size(); ++i)
            n += dot(to_double(block.normal[i]), block.position[i] + block.origin) < 0;
        return n;
    }
};

/// The cloud with other normals.
template <class Normal>
Cloud with_normals(Cloud cloud, const Normal& normal) {
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud.normals[i] = normal(cloud.normals[i], i);
    return cloud;
}

TEST_F(GivenNormals, EstimatesNormalsThatAreThoseOfNoSurface) {
    const auto up = [](const Vec3f&, std::size_t) { return Vec3f{0, 0, 1}; };
    slice(write(with_normals(sampled("sphere", 10000), up), "c.ply"), 1);
    EXPECT_EQ(normals()["estimated"], 10000);
    EXPECT_EQ(inwards(oriented()), 0u);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("off the surface"), std::string::npos)
        << listener_.warnings[0];
    // A plane's are constant, too, and right.
    listener_.warnings.clear();
    slice(write(sampled("plane", 10000), "d.ply"), 1);
    EXPECT_EQ(normals()["kept"], 10000);
    EXPECT_TRUE(listener_.warnings.empty());
}

TEST_F(GivenNormals, SaysThatNormalsAreMissingThatAreZero) {
    const auto zero = [](const Vec3f& n, std::size_t i) { return i % 40 == 0 ? Vec3f{} : n; };
    slice(write(with_normals(sampled("sphere", 10000), zero), "c.ply"), 1);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("250 normals are 0,0,0 or not finite"),
              std::string::npos)
        << listener_.warnings[0];
    EXPECT_EQ(normals()["estimated"], 250);
}

TEST_F(GivenNormals, SaysOfRandomSignsThatNeighboursOpposeEachOther) {
    const auto random = [](const Vec3f& n, std::size_t i) { return i * 7919 % 2 ? n : -n; };
    Cloud cloud = sampled("sphere", 10000);
    for (std::size_t i = 1; i < cloud.size(); i += 2) {  // two points at each place, of both signs
        cloud.positions[i] = cloud.positions[i - 1];
        cloud.normals[i] = cloud.normals[i - 1];
    }
    slice(write(with_normals(cloud, random), "c.ply"), 1);
    normals();
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("% of neighbouring normals oppose each other"),
              std::string::npos)
        << listener_.warnings[0];
    EXPECT_EQ(listener_.warnings[0].find("majority"), std::string::npos)
        << listener_.warnings[0];
}

TEST_F(GivenNormals, SaysThatACountOfAPTSIsTooSmall) {
    std::string text = "100\n";
    const Cloud sphere = sampled("sphere", 300);
    for (const Vec3d& p : sphere.positions) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
    slice(folder_.write("c.pts", text), 1);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("200 points more than its count says"),
              std::string::npos)
        << listener_.warnings[0];
    listener_.warnings.clear();
    text.replace(0, 3, "300");
    slice(folder_.write("d.pts", text + text), 1);  // two blocks, of a count each
    EXPECT_TRUE(listener_.warnings.empty());
}

TEST_F(GivenNormals, TurnsPatchesOfAWholeCloudAndSaysSoOfSlices) {
    Cloud sphere = sampled("sphere", 20000);
    std::size_t n = 0;
    for (std::size_t i = 0; i < sphere.size(); ++i) {
        const Vec3d& p = sphere.positions[i];
        if (p.x * p.y > 0 && p.z > 0) sphere.normals[i] = -sphere.normals[i], ++n;
    }
    slice(write(sphere, "c.ply"), 1);
    const auto r = normals();
    EXPECT_NEAR(r["of_contrary_patches"].get<double>(), static_cast<double>(n), 20);
    EXPECT_EQ(r["estimated"], 0);
    EXPECT_EQ(inwards(oriented()), 0u);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("lie in patches"), std::string::npos);
    EXPECT_TRUE(listener_.warnings[0].ends_with(": turned")) << listener_.warnings[0];

    listener_.warnings.clear();
    slice(write(sphere, "c.ply"), 2);
    normals();
    ASSERT_FALSE(listener_.warnings.empty());
    EXPECT_NE(listener_.warnings[0].find("they are kept"), std::string::npos);
}

TEST_F(GivenNormals, SaysThatNormalsOfAClosedSurfacePointInwards) {
    const auto turned = [](const Vec3f& n, std::size_t) { return -n; };
    const Cloud sphere = sampled("sphere", 20000);
    for (const int slices : {1, 3}) {
        listener_.warnings.clear();
        slice(write(with_normals(sphere, turned), "c.ply"), slices);
        const auto r = normals();
        EXPECT_EQ(r["kept"], 20000);
        EXPECT_TRUE(r["inward"]);
        ASSERT_EQ(listener_.warnings.size(), 1u);
        EXPECT_NE(listener_.warnings[0].find("--normals flip"), std::string::npos);
    }
    // Of a bowl nothing is known; neither of a cloud whose normals are to stay.
    Cloud bowl;
    for (std::size_t i = 0; i < sphere.size(); ++i) {
        if (sphere.positions[i].z > 0) continue;
        bowl.positions.push_back(sphere.positions[i]);
        bowl.normals.push_back(-sphere.normals[i]);
        bowl.scan_ids.push_back(0);
    }
    listener_.warnings.clear();
    slice(write(bowl, "d.ply"), 1);
    EXPECT_FALSE(normals()["inward"]);
    EXPECT_TRUE(listener_.warnings.empty());
}

TEST_F(GivenNormals, TurnsAScanThatOpposesTheOthers) {
    Cloud cloud = sampled("sphere", 40000);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        cloud.scan_ids[i] = static_cast<std::uint16_t>(i % 12);
        if (i % 12 == 7) cloud.normals[i] = -cloud.normals[i];
    }
    slice(write(cloud, "c.ply"), 1);
    const auto r = normals();
    EXPECT_EQ(r["of_contrary_scans"], 40000 / 12);
    EXPECT_EQ(r["estimated"], 0);
    EXPECT_EQ(r["turned"], 0);
    EXPECT_EQ(inwards(oriented()), 0u);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("turned round against"), std::string::npos);
}

TEST_F(GivenNormals, AScanOfTheOtherSideOfAThinSheetStays) {
    Cloud cloud = sampled("plane", 40000);
    const double spacing = 2.0 / 200;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const bool behind = i % 2 == 1;
        cloud.scan_ids[i] = behind ? 1 : 0;
        if (!behind) continue;
        cloud.positions[i] -= 0.4 * spacing * to_double(cloud.normals[i]);
        cloud.normals[i] = -cloud.normals[i];
    }
    slice(write(cloud, "c.ply"), 1);
    const auto r = normals();
    EXPECT_EQ(r["of_contrary_scans"], 0);
    EXPECT_EQ(r["estimated"], 0);
}

TEST_F(GivenNormals, FlipTurnsAllRound) {
    NormalsConfig config;
    config.normals = "flip";
    for (const bool own :
         {true,
          false})  // given ones, and estimated ones, whose signs carry over from slice to slice
        for (const int slices : {1, 3}) {
            SCOPED_TRACE(fmt::format("{} {}", own, slices));
            slice(write(sampled("sphere", 20000), own ? "c.ply" : "d.ply", own), slices);
            EXPECT_TRUE(normals(config)["inward"] == own);
            for (int i = 0; i < slices; ++i) {
                const PointBlock block = oriented(static_cast<std::size_t>(i));
                EXPECT_EQ(inwards(block), block.size());
            }
        }
}

}  // namespace
}  // namespace slim::test
