#include "raytrace/brute/brute_renderer.h"
#include "raytrace/project/forward_renderer.h"
#include "raytrace/trace/trace_renderer.h"
#include "tests/raytrace/support/like_brute.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>

namespace slim {
namespace {

using test::request_for, test::rough_model, test::sharp_model;

GBuffer projected(const SurfelTreeData& model, const RenderRequest& request) {
    GBuffer out;
    render_forward(model.view(), request, out);
    return out;
}

GBuffer traced(const SurfelTreeData& model, const RenderRequest& request) {
    const SurfelTree tree = model.view();
    const ScenePart part{&tree, {}};
    GBuffer out;
    render_traced(TraceScene(std::span(&part, 1), request.loose), request, out);
    return out;
}

/// Pixels of one picture of the unit sphere on which another has none.
std::uint64_t lost(const GBuffer& of, const GBuffer& in) {
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < of.n_pixels(); ++i) n += of.hit[i] && !in.hit[i];
    return n;
}

/// Pixels beyond the outline of the unit sphere about the origin, by more than `margin`.
std::uint64_t beyond(const GBuffer& picture, const RenderRequest& request, double margin) {
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    std::uint64_t n = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const Vec3d o = view.ray_origin(x + 0.5, y + 0.5), d = view.ray_direction(x + 0.5, y + 0.5);
            const Vec3d nearest = o - d * dot(o, d);
            n += picture.hit[picture.index(x, y)] && length(nearest) > 1 + margin;
        }
    return n;
}

class CleanOutlinesTest : public testing::TestWithParam<int> {};

TEST_P(CleanOutlinesTest, AreTheSameInAllRenderers) {
    for (const bool sharp : {false, true}) {
        const auto model = sharp ? sharp_model(GetParam(), 7) : rough_model(GetParam(), 7);
        for (const bool orthographic : {false, true}) {
            SCOPED_TRACE(testing::Message() << "sharp " << sharp << " ortho " << orthographic);
            RenderRequest request = request_for(model, "right", orthographic, 200);
            const GBuffer plain = projected(model, request);
            request.clean_outlines = true;
            const GBuffer clean = projected(model, request);
            EXPECT_GT(lost(plain, clean), 0u);
            EXPECT_EQ(lost(clean, plain), 0u);
            test::expect_like_brute(model, request, clean);
            test::expect_like_brute(model, request, traced(model, request));
        }
    }
}

TEST_P(CleanOutlinesTest, LetNothingStandBeyondASphere) {
    const auto model = test::sphere_model(1, 150, GetParam());  // coarse: caps stand out
    RenderRequest request = request_for(model, "iso", false, 400);
    const std::uint64_t plain = beyond(projected(model, request), request, 0.005);
    request.clean_outlines = true;
    const GBuffer clean = projected(model, request);
    EXPECT_GT(plain, 40u);
    EXPECT_LE(4 * beyond(clean, request, 0.005), plain);
    // No hole opens within it.
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    for (int y = 0; y < clean.height; ++y)
        for (int x = 0; x < clean.width; ++x) {
            const Vec3d o = view.ray_origin(x + 0.5, y + 0.5),
                        d = view.ray_direction(x + 0.5, y + 0.5);
            if (length(o - d * dot(o, d)) > 0.97) continue;
            EXPECT_TRUE(clean.hit[clean.index(x, y)]) << x << ' ' << y;
        }
}

INSTANTIATE_TEST_SUITE_P(Degrees, CleanOutlinesTest, testing::Values(1, 2, 3));

}  // namespace
}  // namespace slim
