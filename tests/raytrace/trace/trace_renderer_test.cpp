#include "raytrace/trace/trace_renderer.h"

#include "raytrace/project/forward_renderer.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "tests/raytrace/support/like_brute.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace slim {
namespace {

using test::request_for, test::rough_model, test::sharp_model, test::traced;

void expect_agreement(const SurfelTreeData& model, const RenderRequest& request) {
    test::expect_like_brute(model, request, traced(model, request));
}

class TraceTest : public testing::TestWithParam<int> {};

TEST_P(TraceTest, AgreesWithTheReferenceOnASphere) {
    const auto model = test::sphere_model(1, 800, GetParam());
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "iso", orthographic, 200));
}

TEST_P(TraceTest, AgreesWithTheReferenceOnARoughModel) {
    const auto model = rough_model(GetParam(), 7);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 200));
}

TEST_P(TraceTest, AgreesWithTheReferenceOnSharpSurfels) {
    const auto model = sharp_model(GetParam(), 7);
    for (const bool orthographic : {false, true})
        expect_agreement(model, request_for(model, "right", orthographic, 200));
}

TEST_P(TraceTest, AgreesWithTheReferenceOnRims) {
    auto model = rough_model(GetParam(), 7);
    const RenderRequest request = request_for(model, "right", false, 200);
    const GBuffer whole = traced(model, request);
    for (std::size_t i = 1; i < model.nodes.size(); ++i) {
        const auto first = static_cast<PackedRim>(keyed_hash(3, i));
        const auto second = static_cast<PackedRim>(keyed_hash(5, i));
        model.nodes[i].set_rims({first, first == 0 ? PackedRim{0} : second});
    }
    EXPECT_NE(whole.position[2], traced(model, request).position[2]);
    expect_agreement(model, request);
}

TEST_P(TraceTest, AgreesWithTheReferenceFromWithin) {
    const auto model = rough_model(GetParam(), 8);
    RenderRequest request = request_for(model, "front", false, 150);
    request.camera.eye = {0, 0, 1.04};  // within the ball of the pole's surfel
    request.camera.target = {0.3, 0.5, 0.2};
    request.camera.fov_y_deg = 90;
    request.camera.near_plane = 0.01;
    expect_agreement(model, request);
    request.camera.eye = {0.1, 0.1, 0};  // inside the sphere
    expect_agreement(model, request);
}

INSTANTIATE_TEST_SUITE_P(Degrees, TraceTest, testing::Values(1, 2, 3));

TEST(TraceRenderer, DepthIsThatOfForwardProjection) {
    const auto model = rough_model(2, 5);
    const RenderRequest request = request_for(model, "iso", false, 300);
    const GBuffer rays = traced(model, request);
    GBuffer forward;
    render_forward(model.view(), request, forward);
    const test::Difference d = test::difference(model, request, rays, forward);
    EXPECT_GT(d.covered, 10000u);
    // Either may differ from the reference in a pixel of 10,000, at edges of cores, where a
    // rounding decides.
    EXPECT_LE(d.hit + d.depth, d.covered / 2000);
    EXPECT_LE(d.normal, d.covered / 2000);
}

// However large or far off a model's units are.
TEST(TraceRenderer, IsExactAtAnyScale) {
    for (const double scale : {1e-20, 1e15}) {
        const auto model = test::sphere_model(scale, 400);
        expect_agreement(model, request_for(model, "iso", false, 80));
    }
}

void expect_same(const GBuffer& a, const GBuffer& b) {
    EXPECT_EQ(a.hit, b.hit);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.k1, b.k1);
    EXPECT_EQ(a.surfel_id, b.surfel_id);
}

TEST(TraceRenderer, ThreadsDoNotMatter) {
    const auto model = rough_model(2, 5);
    const RenderRequest request = request_for(model, "iso", false, 90);
    const auto with = [&](int n) {
        const ThreadLimit limit(n);
        return traced(model, request);
    };
    const GBuffer one = with(1);
    expect_same(one, with(2));
    expect_same(one, with(7));
}

TEST(TraceRenderer, AWindowIsAPartOfThePicture) {
    const auto model = rough_model(3, 5);
    RenderRequest request = request_for(model, "iso", false, 90);
    const GBuffer whole = traced(model, request);
    request.window = {13, 21, 50, 33};
    const GBuffer part = traced(model, request);
    for (int y = 0; y < 33; ++y)
        for (int x = 0; x < 50; ++x) {
            const std::size_t i = part.index(x, y), k = whole.index(x + 13, y + 21);
            ASSERT_EQ(part.hit[i], whole.hit[k]);
            ASSERT_EQ(part.depth[i], whole.depth[k]);
            ASSERT_EQ(part.normal[0][i], whole.normal[0][k]);
            ASSERT_EQ(part.surfel_id[i], whole.surfel_id[k]);
        }
}

TEST(TraceRenderer, LooseSurfelsAreDrawnOnlyIfAsked) {
    auto model = test::sphere_model(1, 400);
    for (std::size_t i = 1; i < model.nodes.size(); ++i)
        if (model.view().center(i).z > 0) model.nodes[i].flags |= kLoose;
    RenderRequest request = request_for(model, "front", false, 60);
    EXPECT_LT(traced(model, request).position[2][60 * 30 + 30], 0);  // the far half
    request.loose = true;
    EXPECT_GT(traced(model, request).position[2][60 * 30 + 30], 0.9f);
}

TEST(TraceRenderer, OfSeveralModelsTheNearestIsSeen) {
    const auto big = test::sphere_model(1, 600), small = test::sphere_model(0.4, 200);
    const SurfelTree a = big.view(), b = small.view();
    const ScenePart parts[] = {{&a, {}}, {&b, {0, 0, 2}}};
    RenderRequest request = request_for(big, "front", true, 100);
    request.camera.eye.z = 9;
    GBuffer out;
    TracedPlanes planes;
    render_traced(TraceScene(parts, false), request, out, &planes);
    const std::size_t middle = out.index(50, 50);
    EXPECT_EQ(planes.model[middle], 1);
    EXPECT_NEAR(out.position[2][middle], 2.4, 1e-3);
    int n_small = 0, n_big = 0;
    for (std::size_t i = 0; i < out.n_pixels(); ++i) {
        if (!out.hit[i]) continue;
        const double x = out.position[0][i], y = out.position[1][i],
                     z = out.position[2][i] - (planes.model[i] ? 2 : 0);
        ASSERT_NEAR(std::sqrt(x * x + y * y + z * z), planes.model[i] ? 0.4 : 1, 2e-3);
        ++(planes.model[i] ? n_small : n_big);
    }
    EXPECT_NEAR(static_cast<double>(n_small) / (n_small + n_big), 0.16, 0.02);
}

TEST(TraceRenderer, OfEquallyNearModelsTheFirstIsSeen) {
    // A sheet, and half of it again: coordinates that floats hold from any origin, so that roots
    // are equal.
    std::vector<Surfel> sheet, half;
    for (int i = -8; i <= 8; ++i)
        for (int k = -8; k <= 8; ++k) {
            sheet.push_back(
                {{0.125 * i, 0.125 * k, 0}, 0.25, frame_from_normal(Vec3d{0, 0, 1}), {}, 2});
            if (i > 0) half.push_back(sheet.back());
        }
    const auto whole = test::flat_tree(sheet, 2), again = test::flat_tree(half, 2);
    const SurfelTree a = whole.view(), b = again.view();
    const ScenePart parts[] = {{&a, {}}, {&b, {}}};
    const RenderRequest request = request_for(whole, "front", false, 120);
    GBuffer both;
    TracedPlanes planes;
    render_traced(TraceScene(parts, false), request, both, &planes);
    const GBuffer alone = traced(whole, request);
    EXPECT_EQ(both.surfel_id, alone.surfel_id);
    EXPECT_EQ(both.normal[0], alone.normal[0]);
    EXPECT_EQ(both.depth, alone.depth);
    EXPECT_EQ(std::count_if(planes.model.begin(), planes.model.end(), [](int m) { return m != 0; }),
              0);
}

TEST(TraceRenderer, OnlyWhatIsWantedIsThere) {
    const auto model = test::sphere_model(1, 200);
    RenderRequest request = request_for(model, "front", false, 20);
    request.wanted = kDepthChannel;
    const GBuffer out = traced(model, request);
    EXPECT_EQ(out.depth.size(), 400u);
    EXPECT_TRUE(out.normal[0].empty() && out.k1.empty() && out.surfel_id.empty() &&
                out.position[0].empty());
}

}  // namespace
}  // namespace slim
