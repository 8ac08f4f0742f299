#include "tests/raytrace/trace/light_stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

// Scenes much wider than a model in them: a model's pixels are those of the model alone.

namespace slim {
namespace {

using test::camera_at, test::request_for, test::rough_model, test::sharp_model, test::Stage, test::sun;

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
        // The eye, too, is that far out, in doubles.
        n_wrong += wide.hit[i] != alone.hit[i] || std::abs(wide.depth[i] - alone.depth[i]) > 1e-5f ||
                   std::abs(wide.normal[0][i] - alone.normal[0][i]) > 1e-3f ||
                   std::abs(wide.k1[i] - alone.k1[i]) > 1e-3f * (1 + std::abs(alone.k1[i]));
    }
    EXPECT_GT(n, 5000);
    EXPECT_LE(n_wrong, n / 2000);
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
    int n_wrong = 0;
    for (std::size_t i = 0; i < alone.n_pixels(); ++i)
        n_wrong += wide.hit[i] != alone.hit[i] || std::abs(wide.normal[0][i] - alone.normal[0][i]) > 1e-3f ||
                   std::abs(wide.position[0][i] - alone.position[0][i]) > 1e-5f;
    EXPECT_LE(n_wrong, 5);
}

/// Pixels whose colour differs by more than 0.02.
int n_unlike(const Picture& a, const Picture& b) {
    int n = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        float off = 0;
        for (std::size_t k = i; k < i + 4; ++k) off = std::max(off, std::abs(a.rgba[k] - b.rgba[k]));
        n += !(off <= 0.02f);
    }
    return n;
}

Picture lit(std::vector<ScenePart> more, float mirror, bool ground = false) {
    auto leaves = test::sphere_leaves(1, 600, 6, 2);
    for (Surfel s : test::sphere_leaves(1, 600, 6, 2)) {
        s.center.x += 2.2;
        leaves.push_back(s);
    }
    Stage stage(test::good_model(std::move(leaves)), camera_at({1, 3, 7}, {1, 0, 0}), test::kSize, std::move(more));
    stage.look.rig.lights = {sun({1, 0.4, 0.5})};
    stage.look.rig.sky = stage.look.rig.ground = {0.5f, 0.5f, 0.5f};
    stage.look.materials[0].mirror = mirror;
    stage.look.background = {{1, 0.5f, 0}, {0, 0, 1}, 1};
    stage.look.openness = Openness{1, 16};
    if (ground) stage.look.ground = GroundPlane{{0, 1, 0}, -1, {}};
    const auto open = stage.openness(1, 16);
    return light_rows(stage.surface(), stage.look, open, {0, stage.buffer.height}, stage.counts);
}

TEST_P(WideScene, AModelKeepsItsLight) {
    const auto other = test::sphere_model(1, 100);
    const SurfelTree far = other.view();
    for (const float mirror : {0.0f, 0.7f})
        EXPECT_LE(n_unlike(lit({}, mirror), lit({{&far, away(GetParam())}}, mirror)), 15) << mirror;
}

TEST_P(WideScene, SoDoesTheGroundUnderIt) {
    const auto other = test::sphere_model(1, 100);
    const SurfelTree far = other.view();
    Vec3d level = away(GetParam());
    level.y = 0;
    EXPECT_LE(n_unlike(lit({}, 0, true), lit({{&far, level}}, 0, true)), 15);
}

INSTANTIATE_TEST_SUITE_P(Diagonals, WideScene, testing::Values(20.0, 1e3, 1e5, 1e7));

}  // namespace
}  // namespace slim
