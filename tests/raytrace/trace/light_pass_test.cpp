#include "raytrace/trace/light_pass.h"

#include "raytrace/shade.h"
#include "slim/base/parallel.h"
#include "tests/raytrace/support/like_brute.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace slim {
namespace {

constexpr int kSize = 120;

/// Surfels of a sphere whose fit errors are those of a good fit.
SurfelTreeData good_model(std::vector<Surfel> leaves) {
    auto model = test::flat_tree(std::move(leaves), 2);
    for (TreeNode& node : model.nodes) node.fit_error = 1e-4f;
    return model;
}
SurfelTreeData good_sphere() { return good_model(test::sphere_leaves(1, 600, 6, 2)); }

/// A view, what it sees of a model, and a look.
struct Stage {
    SurfelTreeData data;
    SurfelTree tree;
    TraceScene scene;
    Camera camera;
    PixelView view;
    ShadeView shade;
    GBuffer buffer;
    TracedPlanes traced;
    std::array<std::vector<float>, 3> normals;
    TraceLook look;
    mutable TraceCounts counts;

    explicit Stage(SurfelTreeData model, const Camera& from, int size = kSize)
        : data(std::move(model)),
          tree(data.view()),
          scene(std::vector<ScenePart>{{&tree, {}}}, false),
          camera(from),
          view(pixel_view(camera, size, size)) {
        const double px = view.orthographic ? view.px_per_unit : view.focal_px;
        shade = {view.right,      -view.down,      -view.forward,
                 size / (2 * px), size / (2 * px), view.orthographic};
        RenderRequest request{camera, size, size, kPositionChannel | kNormalChannel, 0, {}, false};
        render_traced(scene, request, buffer, &traced);
        normals = turned_normals(
            size, size, shade, {buffer.normal[0], buffer.normal[1], buffer.normal[2]}, buffer.hit);
        look.rig.up = shade.up;
        look.rig.sky = look.rig.ground = {};
    }

    TracedSurface surface() const {
        return {scene, {view, {0, 0, buffer.width, buffer.height}, buffer, normals}, traced};
    }
    Picture light() const { return light_rows(surface(), look, {}, {0, buffer.height}, counts); }
    std::vector<float> openness(double distance, int samples) const {
        return openness_plane(surface(), {distance, samples}, look.ground, counts);
    }
    Vec3d normal(std::size_t i) const { return {normals[0][i], normals[1][i], normals[2][i]}; }
    Vec3d position(std::size_t i) const {
        return {buffer.position[0][i], buffer.position[1][i], buffer.position[2][i]};
    }
    Vec3d direction(std::size_t i) const {
        const auto w = static_cast<std::size_t>(buffer.width);
        return view.ray_direction(static_cast<double>(i % w) + 0.5,
                                  static_cast<double>(i / w) + 0.5);
    }
    Vec3d eye(std::size_t i) const {
        const auto w = static_cast<std::size_t>(buffer.width);
        return view.ray_origin(static_cast<double>(i % w) + 0.5, static_cast<double>(i / w) + 0.5);
    }
};

Camera camera_at(const Vec3d& eye, const Vec3d& target, double fov = 40) {
    Camera camera;
    camera.eye = eye, camera.target = target, camera.fov_y_deg = fov;
    return camera;
}

LightSource sun(const Vec3d& toward) {
    LightSource light;
    light.toward = normalized(toward);
    light.highlight = 0;
    return light;
}

bool meets_sphere(const Vec3d& p, const Vec3d& d, double radius) {
    const double along = -dot(p, d);
    return along > 0 && sq_length(p + d * along) < radius * radius;
}

/// A ground of pure shadow under the unit sphere, from above.
Stage sphere_on_ground() {
    Stage stage(good_sphere(), camera_at({0, 9, 4}, {0.7, -1, 0}));
    stage.look.ground = GroundPlane{{0, 1, 0}, -1, {}};
    return stage;
}

/// Calls check(pixel, point) for pixels that see the ground.
void for_ground(const Stage& stage, const std::function<void(std::size_t, const Vec3d&)>& check) {
    for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i) {
        if (stage.buffer.hit[i]) continue;
        const Vec3d d = stage.direction(i), o = stage.eye(i);
        if (d.y < -0.01) check(i, o + d * ((-1 - o.y) / d.y));
    }
}

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

TEST(LightPass, NothingNearMeansFullyOpen) {
    std::vector<Surfel> leaves;
    for (int i = -6; i <= 6; ++i)
        for (int k = -6; k <= 6; ++k)
            leaves.push_back(
                {{0.2 * i, 0.2 * k, 0}, 0.4, frame_from_normal(Vec3d{0, 0, 1}), {}, 2});
    const Stage stage(good_model(leaves), camera_at({0.3, 0.2, 5}, {0, 0, 0}, 20));
    for (std::size_t i = 0; i < stage.buffer.n_pixels(); ++i)
        if (stage.buffer.hit[i]) {
            ASSERT_EQ(stage.openness(10, 16)[i], 1);
            break;
        }
    const auto open = stage.openness(10, 16);
    for (std::size_t i = 0; i < open.size(); ++i) ASSERT_EQ(open[i], stage.buffer.hit[i] ? 1 : 0);
}

// Of a half-space of ground, a surface whose normal makes the angle a with the vertical sees the
// share (1 - cos a) / 2.
TEST(LightPass, OpennessOfASphereAboveTheGroundIsTheViewFactor) {
    Stage stage(good_sphere(), camera_at({0, 1, 6}, {0, 0, 0}));
    stage.look.ground = GroundPlane{{0, 1, 0}, -1, {}};
    const auto open = stage.openness(1e4, 64);
    double sum = 0, sq = 0;
    int n = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (!stage.buffer.hit[i]) continue;
        const double off = static_cast<double>(open[i]) - 0.5 * (1 + stage.normal(i).y);
        sum += off, sq += off * off, ++n;
    }
    EXPECT_GT(n, 2000);
    EXPECT_NEAR(sum / n, 0, 0.005);
    EXPECT_LT(std::sqrt(sq / n), 0.05);
    // Only what is within the distance counts.
    const auto near = stage.openness(0.05, 16);
    for (std::size_t i = 0; i < near.size(); ++i)
        if (stage.buffer.hit[i] && stage.position(i).y > -0.9) {
            ASSERT_EQ(near[i], 1);
        }
}

// The same sphere as a neighbour: against directions cast at the sphere itself.
TEST(LightPass, OpennessBesideASphereIsThatOfManyRays) {
    auto leaves = test::sphere_leaves(1, 600, 6, 2);
    for (const Surfel& s : test::sphere_leaves(1, 600, 6, 2)) {
        leaves.push_back(s);
        leaves.back().center.x += 2.2;
    }
    const Stage stage(good_model(leaves), camera_at({1.1, 0.5, 6}, {1.1, 0, 0}), 60);
    const auto open = stage.openness(3, 64);
    double sum = 0;
    int n = 0;
    for (std::size_t i = 0; i < open.size(); i += 7) {
        if (!stage.buffer.hit[i]) continue;
        const Vec3d p = stage.position(i), other = p.x < 1.1 ? Vec3d{2.2, 0, 0} : Vec3d{};
        const Frame<double> frame = frame_from_normal(stage.normal(i));
        int free = 0;
        for (int k = 0; k < 2000; ++k) {
            const double r2 = (k + 0.5) / 2000, a = 2 * std::numbers::pi * kGoldenRatio * k;
            const double r = std::sqrt(r2);
            const Vec3d d =
                frame.world_from_local({r * std::cos(a), r * std::sin(a), std::sqrt(1 - r2)});
            const double along = dot(other - p, d), sq = 1 - sq_length(p + d * along - other);
            free += !(sq > 0 && along - std::sqrt(sq) > 0 && along - std::sqrt(sq) < 3);
        }
        sum += static_cast<double>(open[i]) - free / 2000.0, ++n;
    }
    EXPECT_GT(n, 100);
    EXPECT_NEAR(sum / n, 0, 0.01);
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

Picture without_shadows(Stage& stage) {
    stage.look.shadows = false;
    const Picture out = stage.light();
    stage.look.shadows = true;
    return out;
}

TEST(LightPass, ASphereThrowsNoShadowOnItself) {
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
TEST(LightPass, ABowlLiesInItsOwnShadow) {
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
TEST(LightPass, SurfelsThatDisagreeThrowNoSpeckles) {
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
TEST(LightPass, NothingLeaksBetweenCloseSheets) {
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
        return light_rows(stage.surface(), stage.look, open, {begin, end}, stage.counts);
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
