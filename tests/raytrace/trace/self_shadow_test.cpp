#include "tests/raytrace/trace/light_stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim {
namespace {

using test::camera_at, test::good_model, test::good_sphere, test::Stage, test::sun,
    test::without_shadows;

// What a surface of overlapping surfels must not throw on itself, and what it must.

TEST(SelfShadow, ASphereThrowsNoShadowOnItself) {
    for (const Vec3d& from : {Vec3d{1, 0.1, 0.05}, Vec3d{0, 1, -0.4}, Vec3d{0.2, 0.1, 1}}) {
        Stage stage(good_sphere(), camera_at({0, 0, 5}, {0, 0, 0}), 200);
        stage.look.rig.lights = {sun(from)};
        const Picture lit = stage.light();
        int n_lit = 0, n_speckles = 0;
        const Picture free = without_shadows(stage);
        for (std::size_t i = 0; i < free.rgba.size(); i += 4) {
            n_lit += free.rgba[i] > 0;
            n_speckles += lit.rgba[i] != free.rgba[i];
        }
        EXPECT_GT(n_lit, 500);
        EXPECT_EQ(n_speckles, 0);
    }
}

// The lower half of a sphere, seen from above: what is dark is where the way to the light goes out
// below the rim.
TEST(SelfShadow, ABowlLiesInItsOwnShadow) {
    std::vector<Surfel> leaves;
    for (const Surfel& s : test::sphere_leaves(1, 1500, 6, 2))
        if (s.center.y < -0.02) leaves.push_back(s);
    Stage stage(good_model(leaves), camera_at({0, 6, 0.01}, {0, 0, 0}), 200);
    stage.look.rig.lights = {sun({1, 0.7, 0.2})};
    const Vec3d l = stage.look.rig.lights[0].toward;
    const Picture picture = stage.light();
    int n_dark = 0, n_lit = 0, n_wrong = 0;
    for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i) {
        if (!stage.buffer.hit[i] || dot(stage.normal(i), l) < 0.05) continue;
        const Vec3d p = stage.position(i);
        const double leaves_at = (p + l * (-2 * dot(p, l))).y;
        if (std::abs(leaves_at) < 0.12) continue;  // discs end there, each where it likes
        const bool dark = leaves_at < 0;
        ++(dark ? n_dark : n_lit);
        n_wrong += dark != !(picture.rgba[4 * i] > 0);
    }
    EXPECT_GT(n_dark, 1500);
    EXPECT_GT(n_lit, 1500);
    EXPECT_LT(n_wrong, 10);
}

/// Surfels that stand off the surface by up to `off`, each by its own.
std::vector<Surfel> shaken(std::vector<Surfel> leaves, double off) {
    for (std::size_t i = 0; i < leaves.size(); ++i)
        leaves[i].center +=
            leaves[i].frame.normal * (off * (2 * unit_interval(keyed_hash(5, i)) - 1));
    return leaves;
}

// From outside and, as the inside of a bowl is the back of its surfels, from behind.
TEST(SelfShadow, SurfelsThatDisagreeThrowNoSpeckles) {
    std::vector<Surfel> bowl;
    for (const Surfel& s : test::sphere_leaves(1, 1500, 6, 2))
        if (s.center.y < -0.02) bowl.push_back(s);
    const struct {
        std::vector<Surfel> leaves;
        Vec3d eye, light;
    } cases[] = {{test::sphere_leaves(1, 1500, 6, 2), {0, 0, 5}, {1, 0.4, 0.8}},
                 {bowl, {0, 6, 0.01}, {0.1, 1, 0}}};
    for (const auto& each : cases) {
        Stage stage(good_model(shaken(each.leaves, 0.004)), camera_at(each.eye, {0, 0, 0}), 200);
        stage.look.rig.lights = {sun(each.light)};
        const Vec3d l = stage.look.rig.lights[0].toward;
        const Picture picture = stage.light();
        int n_lit = 0, n_speckles = 0;
        for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i) {
            if (!stage.buffer.hit[i] || dot(stage.normal(i), l) < 0.3) continue;
            ++n_lit, n_speckles += !(picture.rgba[4 * i] > 0);
        }
        EXPECT_GT(n_lit, 5000);
        EXPECT_LT(n_speckles, 5);
    }
}

// A plate 0.02 above another, facing it: its shadow must not be lost, and the light must not leak
// between.
TEST(SelfShadow, NothingLeaksBetweenCloseSheets) {
    std::vector<Surfel> leaves;
    for (const double y : {0.0, 0.02})
        for (int i = -8; i <= 8; ++i)
            for (int k = -8; k <= 8; ++k)
                if (y == 0 || i < 0)
                    leaves.push_back({{0.1 * i, y, 0.1 * k},
                                      0.2,
                                      frame_from_normal(Vec3d{0, y == 0 ? 1.0 : -1.0, 0}),
                                      {},
                                      2});
    // From below the edge of the upper plate, along the gap.
    Stage stage(good_model(leaves), camera_at({0.9, 0.06, 0}, {-0.3, 0.0, 0}, 10), 100);
    stage.look.rig.lights = {sun({0, 1, 0})};
    const Picture picture = stage.light();
    int n = 0, n_leaks = 0;
    for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i) {
        if (!stage.buffer.hit[i] || stage.position(i).x > -0.3 || stage.position(i).y > 0.01)
            continue;
        ++n, n_leaks += picture.rgba[4 * i] > 0;
    }
    EXPECT_GT(n, 50);
    EXPECT_EQ(n_leaks, 0);
}

}  // namespace
}  // namespace slim
