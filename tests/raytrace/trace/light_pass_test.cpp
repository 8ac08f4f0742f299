#include "tests/raytrace/trace/light_stage.h"

#include "slim/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace slim {
namespace {

using test::camera_at, test::for_ground, test::good_model, test::good_sphere, test::kSize,
    test::meets_sphere;
using test::sphere_on_ground, test::Stage, test::sun, test::without_shadows;

TEST(LightPass, TheShadowOfASphereOnTheGroundIsWhereGeometrySays) {
    Stage stage = sphere_on_ground();
    stage.look.rig.lights = {sun({-1, 1.5, 0.3})};
    const Vec3d l = stage.look.rig.lights[0].toward;
    const Picture picture = stage.light();
    int n_dark = 0, n_wrong = 0;
    for_ground(stage, [&](std::size_t i, const Vec3d& p) {
        const bool dark = meets_sphere(p, l, 1);
        n_dark += dark;
        // The surfels' sphere is off by 1e-3 at most.
        if (meets_sphere(p, l, 0.998) == meets_sphere(p, l, 1.004))
            n_wrong += (picture.rgba[4 * i + 3] > 0.5f) != dark;
    });
    EXPECT_GT(n_dark, 250);
    EXPECT_EQ(n_wrong, 0);
}

TEST(LightPass, AnOpaqueGroundKeepsLightFromBelowOffWhatIsAboveAndOneOfShadowsDoesNot) {
    const auto brightness = [](const LightSource& light, std::optional<GroundPlane> ground) {
        Stage stage(good_sphere(), camera_at({0, 1.5, 5}, {0, 0, 0}));
        stage.look.ground = ground;
        stage.look.rig.lights = {light};
        const Picture picture = stage.light();
        double sum = 0;
        for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i)
            if (stage.buffer.hit[i])
                sum += static_cast<double>(picture.rgba[4 * i] * picture.rgba[4 * i + 3]);
        return sum;
    };
    LightSource lamp;
    lamp.kind = LightKind::point, lamp.position = {0, -3, 3}, lamp.reference = 4;
    const Vec3f white{1, 1, 1};
    for (const LightSource& light : {lamp, sun({0, -1, 1})}) {
        const double free = brightness(light, std::nullopt);
        EXPECT_GT(free, 100);
        EXPECT_EQ(brightness(light, GroundPlane{{0, 1, 0}, -1, white}), 0);
        EXPECT_EQ(brightness(light, GroundPlane{{0, 1, 0}, -1, {}}), free);
    }
    // A lamp between the ground and the sphere is above it.
    EXPECT_EQ(brightness(lamp, GroundPlane{{0, 1, 0}, -3.5, white}), brightness(lamp, {}));
}

/// Share of a disc light of this radius, facing its target, that a point sees past the unit sphere.
double visible_share(const Vec3d& p, const LightSource& light) {
    int seen = 0, n = 0;
    double weight = 0, sum = 0;
    for (int i = 0; i < 40; ++i)
        for (int k = 0; k < 40; ++k) {
            const double a = (i + 0.5) / 20 - 1, b = (k + 0.5) / 20 - 1;
            if (a * a + b * b > 1) continue;
            const Vec3d way = light.position + light.u_axis * a + light.v_axis * b - p,
                        d = normalized(way);
            const double w = d.y * dot(d, light.toward) / sq_length(way);
            const bool free = !meets_sphere(p, d, 1);
            sum += free ? w : 0, weight += w, seen += free, ++n;
        }
    return sum / weight;
}

TEST(LightPass, ThePenumbraOfADiscLightIsItsVisibleShare) {
    Stage stage = sphere_on_ground();
    LightSource light;
    light.kind = LightKind::disc, light.position = {-4, 6, 0.5}, light.highlight = 0,
    light.samples = 64;
    light.toward = normalized(light.position), light.reference = length(light.position);
    const Frame<double> frame = frame_from_normal(light.toward);
    light.u_axis = frame.u_axis * 1.2, light.v_axis = frame.v_axis * 1.2;
    stage.look.rig.lights = {light};
    const Picture picture = stage.light();
    double sum = 0, sq = 0;
    int n = 0;
    for_ground(stage, [&](std::size_t i, const Vec3d& p) {
        const double share = visible_share(p, light),
                     drawn = 1 - static_cast<double>(picture.rgba[4 * i + 3]);
        if (share > 0.999 || share < 0.001) return;
        sum += drawn - share, sq += (drawn - share) * (drawn - share), ++n;
    });
    EXPECT_GT(n, 300);
    EXPECT_NEAR(sum / n, 0, 0.004);  // no bias
    EXPECT_LT(std::sqrt(sq / n),
              0.04);  // 64 samples in 8 x 8 cells: the edge crosses about 12 of them
}

TEST(LightPass, AMirrorShowsWhatLiesInTheMirroredDirection) {
    Stage stage(good_sphere(), camera_at({0, 0, 5}, {0, 0, 0}));
    stage.look.materials[0].mirror = 1;
    stage.look.background = {{1, 0.5f, 0}, {0, 0, 1}, 1};
    const Picture picture = stage.light();
    int n = 0;
    for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i) {
        if (!stage.buffer.hit[i]) continue;
        const Vec3d e = -stage.direction(i), m = normalized(stage.position(i));
        if (dot(m, e) < 0.2) continue;
        const Vec3d r = m * (2 * dot(m, e)) - e;
        ASSERT_NEAR(picture.rgba[4 * i], 0.5 + 0.5 * r.y, 0.02);
        ASSERT_NEAR(picture.rgba[4 * i + 2], 0.5 - 0.5 * r.y, 0.02);
        ++n;
    }
    EXPECT_GT(n, 1500);
}

TEST(LightPass, BouncesBoundTheMirrorsWithinMirrors) {
    auto leaves = test::sphere_leaves(1, 600, 6, 2);
    for (const Surfel& s : test::sphere_leaves(1, 600, 6, 2)) {
        leaves.push_back(s);
        leaves.back().center.x += 2.2;
    }
    Stage stage(good_model(leaves), camera_at({1.1, 0.5, 7}, {1.1, 0, 0}));
    stage.look.materials[0].mirror = 1;
    stage.look.background = {{1, 1, 1}, {1, 1, 1}, 1};
    const auto brightness = [&](int bounces) {
        stage.look.bounces = bounces;
        double sum = 0;
        for (const float c : stage.light().rgba) sum += static_cast<double>(c);
        return sum;
    };
    // Without light of their own the balls are dark but for what they mirror.
    const double none = brightness(0), one = brightness(1), two = brightness(2),
                 many = brightness(12);
    EXPECT_LT(none, one);
    EXPECT_LT(one, two);
    EXPECT_LT(two, many);
}

TEST(LightPass, WithoutShadowsItIsThePictureOfForwardShading) {
    Stage stage(good_sphere(), camera_at({1, 2, 4}, {0, 0, 0}));
    stage.look.rig = studio_rig(stage.shade);
    const Picture traced = without_shadows(stage);
    const GBuffer& b = stage.buffer;
    const Picture plain =
        shade(b.width, b.height, stage.shade, {b.normal[0], b.normal[1], b.normal[2]}, b.hit);
    const Picture lit = shade_lit_rows(stage.surface().planes, stage.scene.frame(), stage.look.rig,
                                       {}, {0, b.height});
    for (std::size_t i = 0; i < plain.rgba.size(); ++i) {
        ASSERT_NEAR(traced.rgba[i], plain.rgba[i], 1e-4);  // powers of quick roots
        ASSERT_NEAR(lit.rgba[i], plain.rgba[i], 1e-4);
    }
}

TEST(LightPass, ThreadsAndBandsDoNotMatter) {
    Stage stage = sphere_on_ground();
    LightSource soft = sun({-1, 2, 1});
    soft.u_axis = {0.1, 0, 0}, soft.v_axis = {0, 0, 0.1};
    stage.look.rig = studio_rig(stage.shade);
    stage.look.rig.lights.push_back(soft);
    stage.look.openness = Openness{1, 9};
    const auto open = stage.openness(1, 9);
    const auto rows = [&](int begin, int end) {
        return light_rows(stage.surface(), stage.look, {open}, {begin, end}, stage.counts);
    };
    const auto with = [&](int n) {
        const ThreadLimit limit(n);
        return rows(0, kSize).rgba;
    };
    const auto one = with(1);
    EXPECT_EQ(one, with(2));
    EXPECT_EQ(one, with(7));
    const auto band = rows(31, 58).rgba;
    EXPECT_TRUE(std::equal(band.begin(), band.end(), one.begin() + 4 * 31 * kSize));
}

TEST(LightPass, WhatIsNotAskedForCastsNoRays) {
    Stage stage(good_sphere(), camera_at({0, 0, 5}, {0, 0, 0}));
    stage.look.rig = studio_rig(stage.shade);
    stage.look.rig.lights[0].shadows = false;
    stage.counts = {};
    stage.light();
    EXPECT_EQ(stage.counts.rays, 0u);
    stage.look.rig.lights[0].shadows = true;
    stage.light();
    EXPECT_GT(stage.counts.rays, 1000u);
    EXPECT_LT(stage.counts.rays, stage.buffer.n_pixels());  // one for each hit that faces the light
}

}  // namespace
}  // namespace slim
