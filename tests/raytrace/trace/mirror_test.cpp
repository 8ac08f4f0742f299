#include "tests/raytrace/trace/light_stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

// What a flat mirror shows is what an eye as far behind it sees.

namespace slim {
namespace {

using test::camera_at, test::good_model, test::kSize, test::Stage, test::sun;

constexpr double kMirror = -4;  ///< z of the mirror, which faces +z

SurfelTreeData flat_mirror() {
    std::vector<Surfel> leaves;
    for (int i = -20; i <= 20; ++i)
        for (int k = -20; k <= 20; ++k)
            leaves.push_back(
                {{0.3 * i, 0.3 * k, 0}, 0.6, frame_from_normal(Vec3d{0, 0, 1}), {}, 2});
    return good_model(std::move(leaves));
}

/// Two balls that shade each other.
SurfelTreeData two_balls() {
    auto leaves = test::sphere_leaves(1, 600, 6, 2);
    for (Surfel s : test::sphere_leaves(1, 600, 6, 2)) {
        s.center += Vec3d{1.7, 0.6, -1.2};
        leaves.push_back(s);
    }
    return good_model(std::move(leaves));
}

/// The same, each leaf off by up to a fiftieth: at silhouettes normals look away a little.
SurfelTreeData rough_balls() {
    std::vector<Surfel> leaves;
    for (const Vec3d& middle : {Vec3d{}, Vec3d{1.7, 0.6, -1.2}})
        for (Surfel s : test::sphere_leaves(1, 600, 6, 2)) {
            const double off = 0.02 * std::sin(7.0 * static_cast<double>(leaves.size()));
            s.center += middle + normalized(s.center) * off;
            leaves.push_back(s);
        }
    return good_model(std::move(leaves));
}

/// The eye before the mirror, or where its image is.
Camera eye_at(bool behind) {
    const Vec3d eye{-0.5, 3.5, 2};
    return camera_at(behind ? Vec3d{eye.x, eye.y, 2 * kMirror - eye.z} : eye, {0.5, 1.5, kMirror},
                     30);
}

struct Scene {
    SurfelTreeData mirror = flat_mirror();
    SurfelTree mirror_tree = mirror.view();
    Stage in_mirror, direct;

    explicit Scene(SurfelTreeData (*balls)() = two_balls)
        : in_mirror(balls(), eye_at(false), kSize, {{&mirror_tree, {0, 0, kMirror}}}),
          direct(balls(), eye_at(true)) {}

    template <class Set>
    void for_both(Set&& set) {
        set(in_mirror), set(direct);
        Material glass;
        glass.mirror = 1;
        in_mirror.look.materials.push_back(glass);
    }
};

Picture picture_of(const Stage& stage) {
    std::vector<float> open;
    if (stage.look.openness)
        open = stage.openness(stage.look.openness->distance, stage.look.openness->samples);
    return light_rows(stage.surface(), stage.look, {open}, {0, stage.buffer.height}, stage.counts);
}

/// Green of the pixels that show the balls, directly and in the mirror, where left and right change
/// sides.
struct Pairs {
    std::vector<double> direct, mirrored;

    Pairs(const Scene& s, const Picture& direct_picture, const Picture& mirror_picture) {
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const std::size_t i = s.direct.buffer.index(x, y),
                                  k = s.direct.buffer.index(kSize - 1 - x, y);
                if (!s.direct.buffer.hit[i] || !s.in_mirror.buffer.hit[k] ||
                    s.in_mirror.traced.model[k] != 1)
                    continue;
                direct.push_back(static_cast<double>(direct_picture.rgba[4 * i + 1]));
                mirrored.push_back(static_cast<double>(mirror_picture.rgba[4 * k + 1]));
            }
    }
};

double mean(const std::vector<double>& v) {
    double sum = 0;
    for (const double x : v) sum += x;
    return sum / static_cast<double>(v.size());
}

std::size_t n_apart(const std::vector<double>& a, const std::vector<double>& b, double by) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < a.size(); ++i) n += !(std::abs(a[i] - b[i]) <= by);
    return n;
}

TEST(Mirror, ShowsShadows) {
    Scene scene;
    scene.for_both([](Stage& stage) { stage.look.rig.lights = {sun({1.7, 1.0, -0.5})}; });
    const Picture direct = picture_of(scene.direct);
    const Pairs pairs(scene, direct, picture_of(scene.in_mirror));
    EXPECT_GT(pairs.direct.size(), 1000u);
    EXPECT_LE(n_apart(pairs.direct, pairs.mirrored, 0.02), pairs.direct.size() / 100);
    // Without shadows it would be another picture.
    const Picture shadowless = test::without_shadows(scene.direct);
    EXPECT_GT(mean(Pairs(scene, shadowless, direct).direct), 1.05 * mean(pairs.direct));
}

TEST(Mirror, SilhouettesInItAreNoBacks) {
    Scene scene(rough_balls);
    // All mirrors in a white world: only a ray that is caught within a ball comes back dark.
    scene.for_both([](Stage& stage) {
        stage.look.materials[0].mirror = 1;
        stage.look.background = {{1, 1, 1}, {1, 1, 1}, 1};
        stage.look.bounces = 6;
    });
    const Picture direct = picture_of(scene.direct);
    const Pairs pairs(scene, direct, picture_of(scene.in_mirror));
    ASSERT_GT(pairs.direct.size(), 1000u);
    // 20 where what looks away is turned round, as the back of a sheet is; 4 are rays between the
    // balls that end after the last bounce.
    EXPECT_LE(n_apart(pairs.mirrored, std::vector<double>(pairs.direct.size(), 1.0), 0.5), 8u);
}

TEST(Mirror, ShowsAmbientOcclusion) {
    Scene scene;
    scene.for_both([](Stage& stage) {
        stage.look.rig.sky = stage.look.rig.ground = {0.5f, 0.5f, 0.5f};
        stage.look.openness = Openness{1.5, 64};
    });
    const Picture direct = picture_of(scene.direct);
    const Pairs pairs(scene, direct, picture_of(scene.in_mirror));
    EXPECT_GT(pairs.direct.size(), 1000u);
    EXPECT_NEAR(mean(pairs.mirrored), mean(pairs.direct), 0.002);
    // 64 rays a point on either side: a share is off by 0.03 or so.
    EXPECT_LE(n_apart(pairs.direct, pairs.mirrored, 0.05), pairs.direct.size() / 100);
    scene.direct.look.openness.reset();
    const Picture open = picture_of(scene.direct);
    EXPECT_GT(mean(Pairs(scene, open, direct).direct), 1.02 * mean(pairs.direct));
}

}  // namespace
}  // namespace slim
