#include "raytrace/brute/brute_renderer.h"

#include "raytrace/project/forward_renderer.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/like_brute.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

using test::request_for, test::rough_model, test::sharp_model;

void expect_agreement(const SurfelTreeData& model, const RenderRequest& request) {
    GBuffer fast;
    render_forward(model.view(), request, fast);
    test::expect_like_brute(model, request, fast);
}

class BruteTest : public testing::TestWithParam<int> {};

TEST_P(BruteTest, AgreesWithTheFastRendererOnASphere) {
    const auto model = test::sphere_model(1, 800, GetParam());
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "iso", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererOnARoughModel) {
    const auto model = rough_model(GetParam(), 7);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererOnSharpSurfels) {
    const auto model = sharp_model(GetParam(), 7);
    ASSERT_GT(model.sharp.size(), 400u);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererOnRims) {
    auto model = rough_model(GetParam(), 7);
    const RenderRequest request = request_for(model, "right", false, 250);
    GBuffer whole, cut;
    render_forward(model.view(), request, whole);
    for (std::size_t i = 1; i < model.nodes.size(); ++i) {
        const auto first = static_cast<PackedRim>(keyed_hash(3, i));
        const auto second = static_cast<PackedRim>(keyed_hash(5, i));
        model.nodes[i].set_rims({first, first == 0 ? PackedRim{0} : second});
    }
    render_forward(model.view(), request, cut);
    EXPECT_NE(whole.position[2], cut.position[2]);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 250));
}

TEST_P(BruteTest, AgreesWithTheFastRendererInsideABall) {
    const auto model = rough_model(GetParam(), 8);
    RenderRequest request = request_for(model, "front", false, 200);
    request.camera.eye = {0, 0, 1.04};  // within the ball of the pole's surfel
    request.camera.target = {0.3, 0.5, 0.2};
    request.camera.fov_y_deg = 90;
    request.camera.near_plane = 0.01;
    expect_agreement(model, request);
    request.camera.eye = {0.1, 0.1, 0};  // inside the sphere
    expect_agreement(model, request);
}

INSTANTIATE_TEST_SUITE_P(Degrees, BruteTest, testing::Values(1, 2, 3));

TEST(BruteRenderer, AgreesWithTheFastRendererAtExtremeAngles) {
    const auto model = rough_model(2, 9);
    RenderRequest request = request_for(model, "front", false, 150);
    request.camera.eye = {0, 0, 1.5};
    request.camera.fov_y_deg = 150;
    expect_agreement(model, request);
    request.camera.eye = {0, 0, 30000};
    request.camera.fov_y_deg = 0.001;
    expect_agreement(model, request);
}

TEST(BruteRenderer, DoesNotDrawInternalNodes) {
    const auto model = test::two_level_sphere(1, 50, 400);
    RenderRequest request = request_for(model, "front", true, 40);
    GBuffer out;
    const auto stats = render_brute(model.view(), request, out);
    EXPECT_EQ(stats.surfels_drawn, 400u);
    for (std::size_t i = 0; i < out.n_pixels(); ++i)
        if (out.hit[i]) { ASSERT_GT(out.surfel_id[i], 50u); }
}

TEST(BruteRenderer, LooseSurfelsAreNeitherHitNorBlendedUnlessAsked) {
    // A disc in front of a sphere and one sunk into it, which would be blended.
    auto leaves = [] {
        std::vector<Surfel> out;
        for (std::size_t i = 0; i < 800; ++i)
            out.push_back(test::sphere_surfel(test::fibonacci_point(i, 800), 1, 0.16, 2));
        return out;
    }();
    const std::size_t n_sphere = leaves.size();
    const auto sphere = test::flat_tree(leaves, 2);
    const auto disc = [](const Vec3d& center) {
        return Surfel{center, 0.3, frame_from_normal(round_normal({0, 0, 1})), {}, 2};
    };
    leaves.push_back(disc({0, 0, 1.3}));
    leaves.push_back(disc({0, 0, 0.97}));
    auto model = test::flat_tree(leaves, 2);
    model.header.bounds = sphere.header.bounds;
    for (std::size_t i = n_sphere + 1; i < model.nodes.size(); ++i) model.nodes[i].flags |= kLoose;
    RenderRequest request = request_for(model, "front", true, 200);
    for (const bool brute : {false, true}) {
        const auto draw = [&](const SurfelTreeData& data, bool loose, GBuffer& out) {
            request.loose = loose;
            return brute ? render_brute(data.view(), request, out)
                         : render_forward(data.view(), request, out);
        };
        GBuffer plain, without, with;
        draw(sphere, false, plain);
        EXPECT_EQ(draw(model, false, without).loose_hidden, 2u);
        EXPECT_EQ(draw(model, true, with).loose_hidden, 0u);
        EXPECT_EQ(without.hit, plain.hit);
        EXPECT_EQ(without.count, plain.count);
        EXPECT_NE(with.count, plain.count);
        EXPECT_NE(with.surfel_id, plain.surfel_id);
        for (std::size_t i = 0; i < plain.n_pixels(); ++i)  // other page origins, other roundings
            ASSERT_NEAR(without.depth[i], plain.depth[i], 1e-5);
    }
    expect_agreement(model, request);
}

}  // namespace
}  // namespace slim
