#include "raytrace/lines/extract.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/project/forward_renderer.h"
#include "tests/raytrace/lines/analytic_buffer.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim {
namespace {

const std::vector<LineKind> kContours{LineKind::contour};

double length_of(const std::vector<FeatureLine>& lines) {
    double sum = 0;
    for (const FeatureLine& line : lines) sum += static_cast<double>(line.length);
    return sum;
}

/// A wall that faces the eye, pixels of a unit, with a flake of 60 x 40 that stands `height` before
/// it.
struct Flake {
    static constexpr int kSize = 200;
    GBuffer buffer;
    PixelView view;

    Flake(float height, float fit_error) {
        Camera camera;
        camera.eye = {0, 0, 100}, camera.orthographic = true, camera.width = kSize;
        view = pixel_view(camera, kSize, kSize);
        buffer.reset(kSize, kSize, line_channels(kContours, 2));
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const std::size_t i = buffer.index(x, y);
                const bool on = x >= 70 && x < 130 && y >= 80 && y < 120;
                const Vec3f p =
                    to_float(view.point_at(x + 0.5, y + 0.5, on ? 100.0f - height : 100.0f));
                buffer.hit[i] = 1, buffer.fit_error[i] = fit_error, buffer.normal[2][i] = 1;
                for (std::size_t axis = 0; axis < 3; ++axis) buffer.position[axis][i] = p[axis];
            }
    }
    std::vector<FeatureLine> lines() const {
        return extract_lines({buffer, view, kSize, 2}, kContours);
    }
};

TEST(Contours, AStepThatSurfelsDisagreeByIsNone) {
    const auto step = Flake(5, 0.1f).lines();
    ASSERT_EQ(step.size(), 1u);
    EXPECT_TRUE(step[0].closed);
    EXPECT_NEAR(step[0].length_px, 200, 8);  // corners are rounded
    EXPECT_TRUE(Flake(5, 2).lines().empty());
    EXPECT_EQ(Flake(50, 2).lines().size(), 1u);
}

TEST(Contours, TheBorderOfWhatIsCoveredHasNoGapAtAFlap) {
    // A wall that ends before nothing at x = 100; a surfel reaches 2 pixels beyond it, for 14, and
    // stands before it.
    Flake wall(0, 0.1f);
    for (int y = 0; y < Flake::kSize; ++y)
        for (int x = 0; x < Flake::kSize; ++x) {
            const bool on_flap = x >= 99 && x < 102 && y >= 90 && y < 104;
            const std::size_t i = wall.buffer.index(x, y);
            wall.buffer.hit[i] = x < 100 || on_flap;
            if (on_flap) wall.buffer.position[2][i] += 12;
        }
    std::vector<int> rows(Flake::kSize);
    for (const FeatureLine& line : wall.lines())
        line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
            const auto [from, to] = std::minmax(a.y, b.y);
            for (int y = static_cast<int>(from); y <= static_cast<int>(to); ++y)
                rows[static_cast<std::size_t>(y)] = 1;
        });
    for (int y = 1; y + 1 < Flake::kSize; ++y)
        EXPECT_EQ(rows[static_cast<std::size_t>(y)], 1) << y;
}

/// A sphere of 80 pixels whose surfels overshoot the limb by a pixel or two here and there,
/// turned away and deep.
GBuffer frayed_sphere(const Camera& camera, const PixelView& view, int size) {
    GBuffer b = test::ellipsoid_buffer(camera, size, {1, 1, 1});
    const std::vector<std::uint8_t> sphere = b.hit;
    for (int y = 2; y < size - 2; ++y)
        for (int x = 2; x < size - 2; ++x) {
            const std::size_t i = b.index(x, y);
            const double r = std::hypot(x + 0.5 - size / 2.0, y + 0.5 - size / 2.0);
            const int part =
                static_cast<int>((std::atan2(y - size / 2.0, x - size / 2.0) + 4) * 12);
            if (sphere[i] || r > 81.2 || part % 3 == 0) continue;
            const Vec3f p = to_float(view.point_at(x + 0.5, y + 0.5, 10 + 0.1));
            const double across = 80.0 / 81;
            const Vec3d out =
                normalized(Vec3d{0, static_cast<double>(p.y), static_cast<double>(p.z)}) * across;
            const Vec3f n = to_float(Vec3d{-std::sqrt(1 - across * across), out.y, out.z});
            b.hit[i] = 1;
            for (std::size_t axis = 0; axis < 3; ++axis)
                b.position[axis][i] = p[axis], b.normal[axis][i] = n[axis];
        }
    return b;
}

TEST(Contours, ALimbThatSurfelsOvershootIsOneLine) {
    const int size = 200;
    const Camera camera = test::camera_from_x(2.5);
    const PixelView view = pixel_view(camera, size, size);
    const auto lines = extract_lines({frayed_sphere(camera, view, size), view, 3.4, 2}, kContours);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].closed);
    EXPECT_NEAR(lines[0].length_px, 2 * std::numbers::pi * 80, 16);  // up and down the frays
    for (const LinePoint& p : lines[0].points)
        EXPECT_NEAR(std::hypot(p.x - 100, p.y - 100), 80.5, 1.3);
}

Camera camera_from(const Vec3d& side, double distance) {
    Camera camera;
    camera.eye = normalized(side) * distance, camera.up = {0, 0, 1};
    camera.orthographic = true, camera.width = 3.2;
    return camera;
}

std::vector<FeatureLine> torus_lines(const SurfelTreeData& model, const Camera& camera,
                                     const PixelView& view) {
    RenderRequest request;
    request.camera = camera, request.width = request.height = 400, request.lod_px = 0;
    request.wanted = line_channels(kContours, 2);
    GBuffer buffer;
    render_forward(model.view(), request, buffer);
    return extract_lines({buffer, view, model.header.diagonal, 2}, kContours);
}

TEST(Contours, FromAMillionDiagonalsAwayAreThoseFromNearby) {
    const SurfelTreeData model = test::torus_model(1, 0.35, 90, 36, 2);
    const double diagonal = model.header.diagonal;
    const Vec3d side{3, 1, 1.2};
    const auto seen_from = [&](double distance) {
        const Camera camera = camera_from(side, distance * diagonal);
        return torus_lines(model, camera, pixel_view(camera, 400, 400));
    };
    const auto near = seen_from(2);
    ASSERT_FALSE(near.empty());
    for (const double distance : {1e4, 1e6, 1e7}) {
        const auto far = seen_from(distance);
        EXPECT_EQ(far.size(), near.size()) << distance;
        EXPECT_NEAR(length_of(far), length_of(near), 0.01 * length_of(near)) << distance;
        for (const FeatureLine& line : far)
            for (const LinePoint& p : line.points)  // on the tube, to a pixel
                EXPECT_NEAR(std::hypot(std::hypot(p.point.x, p.point.y) - 1, p.point.z), 0.35,
                            3.2 / 400)
                    << distance;
    }
}

TEST(Contours, OfOneFrameDoNotDependOnTheEyesDistance) {
    // The same pixels, told to be seen from farther away: the same bytes.
    const SurfelTreeData model = test::torus_model(1, 0.35, 90, 36, 2);
    const auto camera_at = [](double distance) {
        Camera camera = test::camera_from_x(3.2);
        camera.eye.x = distance;
        return camera;
    };
    const auto ply = [&](double distance) {
        return lines_ply(
            torus_lines(model, camera_at(16), pixel_view(camera_at(distance), 400, 400)), {});
    };
    const std::string near = ply(16);
    EXPECT_EQ(near, ply(1 << 22));
    EXPECT_EQ(near, ply(1 << 26));
}

}  // namespace
}  // namespace slim
