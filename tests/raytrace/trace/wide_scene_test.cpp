#include "tests/raytrace/trace/light_stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

// Scenes much wider than a model in them: a model's pixels are those of the model alone.

namespace slim {
namespace {

using test::camera_at, test::request_for, test::rough_model, test::sharp_model, test::Stage,
    test::sun;

/// In diagonals of the models below, about 3.5.
Vec3d away(double diagonals) { return normalized(Vec3d{1, 0.3, -0.7}) * (3.5 * diagonals); }

GBuffer traced(const std::vector<ScenePart>& parts, const RenderRequest& request) {
    GBuffer out;
    render_traced(TraceScene(parts, false), request, out);
    return out;
}

class WideScene : public testing::TestWithParam<double> {};

TEST_P(WideScene, AModelKeepsItsPixels) {
    const auto other = test::sphere_model(1, 100);
    const SurfelTree far = other.view();
    for (const int degree : {1, 2, 3})
        for (const auto& model : {rough_model(degree, 7), sharp_model(degree, 7)}) {
            const SurfelTree tree = model.view();
            for (const bool orthographic : {false, true}) {
                const RenderRequest request = request_for(model, "iso", orthographic, 150);
                test::expect_like_brute(model, request,
                                        traced({{&tree, {}}, {&far, away(GetParam())}}, request));
            }
        }
}

// Its places are far from the job's origin: depths tell what floats of places would not.
TEST_P(WideScene, SoDoesTheFarModel) {
    const auto model = rough_model(2, 7), other = test::sphere_model(1, 100);
    const SurfelTree tree = model.view(), near = other.view();
    RenderRequest request = request_for(model, "iso", false, 150);
    const GBuffer alone = traced({{&tree, {}}}, request);
    const Vec3d offset = away(GetParam());
    request.camera.eye += offset, request.camera.target += offset;
    const GBuffer wide = traced({{&near, {}}, {&tree, offset}}, request);
    int n = 0, n_wrong = 0;
    for (std::size_t i = 0; i < alone.n_pixels(); ++i) {
        n += alone.hit[i];
        // Depths of about 9 in floats are 5e-7 off. The eye, too, is that far out, in doubles: at
        // 1e7 diagonals by 7e-9.
        n_wrong += wide.hit[i] != alone.hit[i] ||
                   std::abs(wide.depth[i] - alone.depth[i]) > 1e-5f ||
                   std::abs(wide.normal[0][i] - alone.normal[0][i]) > 1e-3f ||
                   std::abs(wide.k1[i] - alone.k1[i]) > 1e-3f * (1 + std::abs(alone.k1[i]));
    }
    EXPECT_GT(n, 5000);
    EXPECT_LE(n_wrong, n / 2000);  // pixels at a limb, or where two surfels are met equally far off
}

// An eye far out sees the model through floats of a long way.
TEST_P(WideScene, FromFarOutAModelKeepsItsPixels) {
    const auto model = rough_model(2, 7), other = test::sphere_model(1, 100);
    const SurfelTree tree = model.view(), beside_eye = other.view();
    RenderRequest request = request_for(model, "iso", false, 150);
    const Vec3d from = request.camera.eye;
    request.camera.eye = from * GetParam(), request.camera.fov_y_deg /= GetParam();
    const GBuffer alone = traced({{&tree, {}}}, request);
    const GBuffer wide = traced({{&tree, {}}, {&beside_eye, from * (1.5 * GetParam())}}, request);
    int n = 0, n_wrong = 0;
    for (std::size_t i = 0; i < alone.n_pixels(); ++i) {
        n += alone.hit[i];
        // Places of up to 1.1 are floats, 1e-7 off, after a way of two floats.
        n_wrong += wide.hit[i] != alone.hit[i] ||
                   std::abs(wide.normal[0][i] - alone.normal[0][i]) > 1e-3f ||
                   std::abs(wide.position[0][i] - alone.position[0][i]) > 1e-5f;
    }
    EXPECT_GT(n, 5000);
    EXPECT_LE(n_wrong, n / 1000);  // at limbs and ties
}

// From far out a float of the way to both does not tell which comes first.
TEST_P(WideScene, SeveralModelsKeepTheirOrder) {
    const auto a = rough_model(2, 7), b = rough_model(2, 8), other = test::sphere_model(1, 100);
    const SurfelTree first = a.view(), second = b.view(), beside_eye = other.view();
    RenderRequest request = request_for(a, "iso", false, 150);
    const Vec3d from = request.camera.eye;
    request.camera.eye = from * GetParam(), request.camera.fov_y_deg /= GetParam();
    const std::vector<ScenePart> both{{&first, {}}, {&second, {0.02, -0.01, 0.03}}};
    const auto winners = [&](const std::vector<ScenePart>& parts, GBuffer& out) {
        TracedPlanes planes;
        render_traced(TraceScene(parts, false), request, out, &planes);
        return planes.model;
    };
    auto more = both;
    more.push_back({&beside_eye, from * (1.5 * GetParam())});
    GBuffer alone, wide;
    const auto of_pair = winners(both, alone), of_all = winners(more, wide);
    int n_first = 0, n_second = 0, n_wrong = 0;
    for (std::size_t i = 0; i < alone.n_pixels(); ++i) {
        if (alone.hit[i]) ++(of_pair[i] == 0 ? n_first : n_second);
        n_wrong += wide.hit[i] != alone.hit[i] || (alone.hit[i] && of_all[i] != of_pair[i]);
    }
    EXPECT_GT(n_first, 1000);
    EXPECT_GT(n_second, 1000);
    EXPECT_LE(n_wrong, (n_first + n_second) / 1000);  // pixels where both are met within 1e-6
}

/// Pixels whose colour differs by more than 0.02: one of the 16 rays of openness under the sky of
/// 0.5 is 0.03.
int n_unlike(const Picture& a, const Picture& b) {
    int n = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        float off = 0;
        for (std::size_t k = i; k < i + 4; ++k)
            off = std::max(off, std::abs(a.rgba[k] - b.rgba[k]));
        n += !(off <= 0.02f);
    }
    return n;
}

int n_covered(const Picture& picture) {
    int n = 0;
    for (std::size_t i = 3; i < picture.rgba.size(); i += 4) n += picture.rgba[i] > 0;
    return n;
}

/// Pixels of `wide` that may be unlike: rays that touch a limb, or the rim of a shadow, are told by
/// rounding.
constexpr int kMostTouching = 15;

void expect_alike(const Picture& alone, const Picture& wide) {
    EXPECT_GT(n_covered(alone), 2000);
    EXPECT_LE(n_unlike(alone, wide), kMostTouching);
}

Picture lit(std::vector<ScenePart> more, float mirror, bool ground = false) {
    auto leaves = test::sphere_leaves(1, 600, 6, 2);
    for (Surfel s : test::sphere_leaves(1, 600, 6, 2)) {
        s.center.x += 2.2;
        leaves.push_back(s);
    }
    Stage stage(test::good_model(std::move(leaves)), camera_at({1, 3, 7}, {1, 0, 0}), test::kSize,
                std::move(more));
    stage.look.rig.lights = {sun({1, 0.4, 0.5})};
    stage.look.rig.sky = stage.look.rig.ground = {0.5f, 0.5f, 0.5f};
    stage.look.materials[0].mirror = mirror;
    stage.look.background = {{1, 0.5f, 0}, {0, 0, 1}, 1};
    stage.look.openness = Openness{1, 16};
    if (ground) stage.look.ground = GroundPlane{{0, 1, 0}, -1, {}};
    const auto open = stage.openness(1, 16);
    return light_rows(stage.surface(), stage.look, {open}, {0, stage.buffer.height}, stage.counts);
}

TEST_P(WideScene, AModelKeepsItsLight) {
    const auto other = test::sphere_model(1, 100);
    const SurfelTree far = other.view();
    for (const float mirror : {0.0f, 0.7f}) {
        SCOPED_TRACE(mirror);
        expect_alike(lit({}, mirror), lit({{&far, away(GetParam())}}, mirror));
    }
}

TEST_P(WideScene, SoDoesTheGroundUnderIt) {
    const auto other = test::sphere_model(1, 100);
    const SurfelTree far = other.view();
    Vec3d level = away(GetParam());
    level.y = 0;
    const Picture bare = lit({}, 0), ground = lit({}, 0, true);
    EXPECT_GT(n_unlike(bare, ground), 300);  // it has shadows
    expect_alike(ground, lit({{&far, level}}, 0, true));
}

INSTANTIATE_TEST_SUITE_P(Diagonals, WideScene, testing::Values(20.0, 1e3, 1e5, 1e7));

}  // namespace
}  // namespace slim
