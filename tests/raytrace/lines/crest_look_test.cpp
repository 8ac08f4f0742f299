#include "raytrace/lines/crest_look.h"

#include "tests/raytrace/lines/analytic_buffer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

/// k at height z of the section x^2 + (z / 0.4)^2 = 1.
double curvature_at(double z) {
    const double sq_sine = z * z / 0.16;
    return 0.4 / std::pow(sq_sine + 0.16 * (1 - sq_sine), 1.5);
}

TEST(CrestLook, SharpnessOfAnEllipsesTipAtAnySize) {
    // Where the osculating circle (radius 0.16) has turned by 0.7.
    const double fall = 1 - curvature_at(0.16 * std::sin(0.7)) / 6.25,
                 expected = 2 * fall / (0.7 * 0.7);
    const Camera camera = test::camera_from_x(1.6);
    const LinePoint tip{0, 0, {1, 0, 0}, 6.25f, 0};
    for (const int size : {200, 799, 1600}) {
        const GBuffer buffer = test::ellipsoid_buffer(camera, size, {1, 0.7, 0.4});
        const PixelView view = pixel_view(camera, size, size);
        CurvatureSamples samples;
        samples.add({buffer, view, 2.6, 3});
        EXPECT_NEAR(samples.sharpness(tip, {{1, 0, 0}, {0, 0, 1}}, true), expected, 0.05 * expected)
            << size;
    }
}

TEST(CrestLook, BehindTheLimbNothingIsSeen) {
    // A unit sphere but for its curvature, which falls away from z = 0 alone: of a point 20 degrees
    // before the limb at +y, only the way back is seen.
    const Camera camera = test::camera_from_x(2.4);
    GBuffer buffer = test::ellipsoid_buffer(camera, 300, {1, 1, 1});
    for (std::size_t i = 0; i < buffer.n_pixels(); ++i)
        if (buffer.hit[i]) buffer.k1[i] = buffer.position[1][i] > 0.9f ? 1.0f : 0.8f;
    const PixelView view = pixel_view(camera, 300, 300);
    CurvatureSamples samples;
    samples.add({buffer, view, 3.4, 3});
    const float angle = 70 * 0.0174533f, c = std::cos(angle), s = std::sin(angle);
    const LinePoint near_limb{0, 0, {c, s, 0}, 1, 0};
    EXPECT_NEAR(samples.sharpness(near_limb, {{c, s, 0}, {-s, c, 0}}, true), 2 * 0.2 / 0.49, 1e-3);
}

TEST(CrestLook, WhereNoSideIsSeenItIsNotKnown) {
    const Camera camera = test::camera_from_x(1.6);
    GBuffer nothing;
    nothing.reset(100, 100, kAllChannels);
    const PixelView view = pixel_view(camera, 100, 100);
    CurvatureSamples samples;
    samples.add({nothing, view, 2.6, 3});
    EXPECT_TRUE(
        std::isnan(samples.sharpness({0, 0, {1, 0, 0}, 6.25f, 0}, {{1, 0, 0}, {0, 0, 1}}, true)));
}

}  // namespace
}  // namespace slim
