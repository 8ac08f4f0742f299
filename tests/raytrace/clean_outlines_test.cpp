#include "raytrace/brute/brute_renderer.h"
#include "raytrace/project/forward_renderer.h"
#include "tests/raytrace/support/like_brute.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace slim {
namespace {

using test::request_for, test::rough_model, test::sharp_model, test::traced;

GBuffer projected(const SurfelTreeData& model, const RenderRequest& request) {
    GBuffer out;
    render_forward(model.view(), request, out);
    return out;
}

/// Pixels of one picture of the unit sphere on which another has none.
std::uint64_t lost(const GBuffer& of, const GBuffer& in) {
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < of.n_pixels(); ++i) n += of.hit[i] && !in.hit[i];
    return n;
}

/// visit(x, y, distance of the pixel's ray from the origin).
template <class Visit>
void for_each_ray(const RenderRequest& request, Visit&& visit) {
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    for (int y = 0; y < request.height; ++y)
        for (int x = 0; x < request.width; ++x) {
            const Vec3d o = view.ray_origin(x + 0.5, y + 0.5),
                        d = view.ray_direction(x + 0.5, y + 0.5);
            visit(x, y, length(o - d * dot(o, d)));
        }
}

/// Pixels beyond the outline of the unit sphere about the origin, by more than `margin`.
std::uint64_t beyond(const GBuffer& picture, const RenderRequest& request, double margin) {
    std::uint64_t n = 0;
    for_each_ray(request, [&](int x, int y, double distance) {
        n += distance > 1 + margin && picture.hit[picture.index(x, y)];
    });
    return n;
}

class CleanOutlinesTest : public testing::TestWithParam<int> {};

TEST_P(CleanOutlinesTest, AreTheSameInAllRenderers) {
    for (const bool sharp : {false, true}) {
        const auto model = sharp ? sharp_model(GetParam(), 7) : rough_model(GetParam(), 7);
        for (const double fov : {0.0, 35.0, 120.0}) {
            SCOPED_TRACE(testing::Message() << "sharp " << sharp << " fov " << fov);
            RenderRequest request = request_for(model, "right", fov == 0, 200);
            if (fov > 0) {  // wide: near by, and the sphere in a corner
                request.camera.fov_y_deg = fov;
                if (fov > 90)
                    request.camera.eye = {2.2, 1.1, 0.9}, request.camera.target = {0, 1.6, 1};
            }
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

TEST_P(CleanOutlinesTest, LeaveOutWhatStandsOutOfASphere) {
    const auto model = rough_model(GetParam(), 7);
    RenderRequest request = request_for(model, "iso", false, 400);
    const std::uint64_t plain = beyond(projected(model, request), request, 0.01);
    request.clean_outlines = true;
    const std::uint64_t clean = beyond(projected(model, request), request, 0.01);
    EXPECT_GT(plain, 1000u);
    EXPECT_LT(5 * clean, 4 * plain);
}

TEST(CleanOutlines, OpenNoHoleInASphere) {
    const auto model = test::sphere_model(1, 800);
    RenderRequest request = request_for(model, "iso", false, 400);
    request.clean_outlines = true;
    const GBuffer clean = projected(model, request);
    std::uint64_t holes = 0;
    for_each_ray(request, [&](int x, int y, double distance) {
        holes += distance < 0.98 && !clean.hit[clean.index(x, y)];
    });
    EXPECT_EQ(holes, 0u);
}

INSTANTIATE_TEST_SUITE_P(Degrees, CleanOutlinesTest, testing::Values(1, 2, 3));

}  // namespace
}  // namespace slim
