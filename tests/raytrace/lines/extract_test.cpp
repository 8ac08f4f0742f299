#include "raytrace/lines/extract.h"

#include "raytrace/brute/brute_renderer.h"
#include "raytrace/lines/crossings.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/parallel.h"
#include "tests/raytrace/lines/analytic_buffer.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

namespace slim {
namespace {

std::map<LineKind, float> lengths_of(const std::vector<FeatureLine>& lines) {
    std::map<LineKind, float> out;
    for (const FeatureLine& line : lines) out[line.kind] += line.length;
    return out;
}

std::vector<FeatureLine> exact_lines(const Vec3d& axes, int size, double width) {
    const Camera camera = test::camera_from_x(width);
    const GBuffer buffer = test::ellipsoid_buffer(camera, size, axes);
    const PixelView view = pixel_view(camera, size, size);
    return extract_lines({buffer, view, 2 * length(axes), 3}, kAllLineKinds);
}

/// Everything about a model of degree 3 as a renderer sees it.
struct Rendered {
    GBuffer buffer;
    std::vector<FeatureLine> lines;
};
Rendered rendered_lines(const SurfelTreeData& model, const char* camera, int size, bool brute,
                        double lod = 0) {
    RenderRequest request;
    request.camera = named_camera(camera, model.header.bounds, 1, {.up = UpAxis::z});
    request.width = request.height = size;
    request.wanted = line_channels(kAllLineKinds, model.header.degree);
    request.lod_px = lod;
    Rendered out;
    if (brute)
        render_brute(model.view(), request, out.buffer);
    else
        render_forward(model.view(), request, out.buffer);
    const PixelView view = pixel_view(request.camera, size, size);
    out.lines = extract_lines({out.buffer, view, model.header.diagonal, model.header.degree},
                              kAllLineKinds);
    return out;
}

TEST(ExtractLines, ASphereHasItsContourOnlyAndSubPixel) {
    const auto lines = exact_lines({1, 1, 1}, 200, 2.5);
    std::size_t contours = 0;
    for (const FeatureLine& line : lines) {
        if (line.kind == LineKind::reflection) continue;
        ASSERT_EQ(line.kind, LineKind::contour);
        ++contours;
        EXPECT_TRUE(line.closed);
        double worst = 0;
        for (const LinePoint& p : line.points)
            worst = std::max(worst, std::abs(std::hypot(p.x - 100.0, p.y - 100.0) - 80.0));
        EXPECT_LT(worst, 0.2);  // of a pixel; half a pixel without looking at N.v
        EXPECT_NEAR(line.length_px, 2 * std::numbers::pi * 80, 2);
    }
    EXPECT_EQ(contours, 1u);
}

TEST(ExtractLines, RidgesOfAnEllipsoidLieOnItsSharpestSection) {
    const Vec3d axes{1, 0.7, 0.4};
    const auto lines = exact_lines(axes, 400, 1.6);
    const double pixel = 1.6 / 400;
    double length_found = 0, y_least = 1, y_most = -1;
    for (const FeatureLine& line : lines) {
        EXPECT_NE(line.kind, LineKind::valley);
        EXPECT_NE(line.kind, LineKind::parabolic);
        EXPECT_NE(line.kind, LineKind::suggestive);
        if (line.kind != LineKind::ridge) continue;
        length_found += line.length;
        for (const LinePoint& p : line.points) {
            EXPECT_LT(std::abs(p.point.z), 0.25 * pixel);
            y_least = std::min(y_least, static_cast<double>(p.point.y));
            y_most = std::max(y_most, static_cast<double>(p.point.y));
        }
    }
    EXPECT_LT(y_least, -0.68);
    EXPECT_GT(y_most, 0.68);
    // The arc of the section z = 0 between the same ends.
    double arc = 0;
    const int n = 100000;
    const auto at = [&](int i) {
        const double y = y_least + (y_most - y_least) * i / n;
        return Vec3d{axes.x * std::sqrt(std::max(0.0, 1 - y * y / (axes.y * axes.y))), y, 0};
    };
    for (int i = 0; i < n; ++i) arc += length(at(i + 1) - at(i));
    EXPECT_NEAR(length_found, arc, 0.01 * arc);
}

TEST(ExtractLines, AnEllipsoidTurnedInsideOutHasValleys) {
    const Camera camera = test::camera_from_x(1.6);
    GBuffer b = test::ellipsoid_buffer(camera, 300, {1, 0.7, 0.4});
    test::turn_inside_out(b);
    const PixelView view = pixel_view(camera, 300, 300);
    const LineScene scene{b, view, 2.6, 3};
    const auto lines = extract_lines(scene, std::vector{LineKind::valley, LineKind::ridge});
    const auto lengths = lengths_of(lines);
    ASSERT_TRUE(lengths.contains(LineKind::valley));
    EXPECT_FALSE(lengths.contains(LineKind::ridge));
    EXPECT_GT(lengths.at(LineKind::valley), 2);
}

TEST(ExtractLines, ParabolicLinesOfATorusAreItsTopCircle) {
    for (const int degree : {2, 3}) {
        const auto model = test::torus_model(1, 0.35, 90, 36, degree);
        const auto lines = rendered_lines(model, "top", 400, false).lines;
        double sum = 0;
        for (const FeatureLine& line : lines) {
            if (line.kind != LineKind::parabolic) continue;
            sum += line.length;
            for (const LinePoint& p : line.points) {
                EXPECT_NEAR(std::hypot(p.point.x, p.point.y), 1, 0.02);
                EXPECT_NEAR(p.point.z, 0.35, 0.002);
            }
        }
        EXPECT_NEAR(sum, 2 * std::numbers::pi, 0.02 * 2 * std::numbers::pi);
    }
}

TEST(ExtractLines, ATorusHasNoCrestLines) {
    const auto model = test::torus_model(1, 0.35, 90, 36, 3);
    for (const char* camera : {"top", "front", "iso"}) {
        const auto lengths = lengths_of(rendered_lines(model, camera, 300, false).lines);
        EXPECT_FALSE(lengths.contains(LineKind::ridge)) << camera;
        EXPECT_FALSE(lengths.contains(LineKind::valley)) << camera;
        EXPECT_TRUE(lengths.contains(LineKind::contour));
    }
}

TEST(ExtractLines, SuggestiveContoursAreTheSameInAnyUnit) {
    // A quadratic torus, whose slopes are differences: fourth powers of lengths in the picture.
    const auto crossings_at = [](double scale) {
        const auto model = test::torus_model(scale, 0.35 * scale, 90, 36, 2);
        RenderRequest request;
        request.camera.eye = Vec3d{4, 0, 1.2} * scale, request.camera.up = {0, 0, 1};
        request.width = request.height = 400;
        request.wanted = line_channels(kAllLineKinds, 2), request.lod_px = 0;
        GBuffer buffer;
        render_forward(model.view(), request, buffer);
        const LineScene scene{buffer, pixel_view(request.camera, 400, 400), 3 * scale, 2};
        return suggestive_crossings(scene, Sheets(scene)).crossings;
    };
    const auto reference = crossings_at(1);
    ASSERT_GT(reference.size(), 100u);
    for (const int power : {-36, 36}) {
        SCOPED_TRACE(power);
        const auto crossings = crossings_at(std::ldexp(1.0, power));
        ASSERT_EQ(crossings.size(), reference.size());
        for (std::size_t i = 0; i < crossings.size(); ++i) {
            ASSERT_EQ(crossings[i].pixel, reference[i].pixel);
            ASSERT_EQ(crossings[i].edge, reference[i].edge);
            ASSERT_EQ(crossings[i].x, reference[i].x);
            ASSERT_EQ(crossings[i].y, reference[i].y);
        }
    }
}

TEST(ExtractLines, AnEdgeWithinAPixelIsARidgeOrAValley) {
    // Two planes at a right angle that meet at y = 0.123, seen along their bisector; flat as they
    // are.
    const int size = 120;
    const Camera camera = test::camera_from_x(size);
    const PixelView view = pixel_view(camera, size, size);
    for (const float sign : {1.0f, -1.0f}) {
        GBuffer b;
        b.reset(size, size, kAllChannels);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const std::size_t i = b.index(x, y);
                const Vec3d p = view.point_at(x + 0.5, y + 0.5, 10);
                const auto side = static_cast<float>(p.y) - 0.123f;
                b.hit[i] = 1;
                b.position[0][i] = -sign * std::fabs(side);
                b.position[1][i] = static_cast<float>(p.y),
                b.position[2][i] = static_cast<float>(p.z);
                b.normal[0][i] = std::sqrt(0.5f);
                b.normal[1][i] = std::copysign(std::sqrt(0.5f), sign * side);
            }
        const auto lines =
            extract_lines({b, view, 100, 3}, std::vector{LineKind::ridge, LineKind::valley});
        ASSERT_EQ(lines.size(), 1u);
        EXPECT_EQ(lines[0].kind, sign > 0 ? LineKind::ridge : LineKind::valley);
        EXPECT_NEAR(lines[0].length_px, size - 1, 0.1);
        // A turn of 90 degrees over sqrt(2) pixels or so.
        EXPECT_GT(lines[0].strength, 100);
        for (const LinePoint& p : lines[0].points) EXPECT_NEAR(p.point.y, 0.123f, 0.05f);
    }
}

TEST(ExtractLines, BothWaysOfTakingTheSlopeOfRadialCurvatureAgree) {
    const auto model = test::torus_model(1, 0.35, 90, 36, 3);
    RenderRequest request;
    request.camera.eye = {4, 0, 1.2}, request.camera.up = {0, 0, 1};
    request.width = request.height = 400;
    request.wanted = line_channels(kAllLineKinds, 3), request.lod_px = 0;
    GBuffer buffer;
    render_forward(model.view(), request, buffer);
    const PixelView view = pixel_view(request.camera, 400, 400);
    const Sheets sheets({buffer, view, 3, 3});
    const CrossingField exact = suggestive_crossings({buffer, view, 3, 3}, sheets);
    const CrossingField differences = suggestive_crossings({buffer, view, 3, 2}, sheets);
    const auto by_edge = [](const CrossingField& field) {
        std::map<std::pair<std::size_t, std::uint32_t>, float> evidence;
        for (std::size_t y = 0; y + 1 < field.row_start.size(); ++y)
            for (std::size_t i = field.row_start[y]; i < field.row_start[y + 1]; ++i)
                evidence[{y, field.crossings[i].edge}] = field.crossings[i].evidence;
        return evidence;
    };
    std::vector<float> ratios;
    const auto exactly = by_edge(exact);
    for (const auto& [edge, evidence] : by_edge(differences))
        if (const auto found = exactly.find(edge); found != exactly.end())
            ratios.push_back(evidence / found->second);
    ASSERT_GT(ratios.size(), 20u);
    std::nth_element(ratios.begin(),
                     ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
    EXPECT_NEAR(ratios[ratios.size() / 2], 1, 0.1);
}

TEST(ExtractLines, AreTheSameForAnyNumberOfThreads) {
    const Camera camera = test::camera_from_x(1.6);
    // several bands of rows
    const GBuffer buffer = test::ellipsoid_buffer(camera, 300, {1, 0.7, 0.4});
    const PixelView view = pixel_view(camera, 300, 300);
    const auto lines_with = [&](int threads) {
        const ThreadLimit limit(threads);
        return lines_ply(extract_lines({buffer, view, 2.6, 3}, kAllLineKinds), {});
    };
    const std::string one = lines_with(1);
    EXPECT_EQ(one, lines_with(2));
    EXPECT_EQ(one, lines_with(5));
}

TEST(ExtractLines, TheBruteRendererGivesTheSameLines) {
    const auto model = test::torus_model(1, 0.35, 60, 24, 3);
    const auto fast = lengths_of(rendered_lines(model, "iso", 200, false).lines);
    const auto slow = lengths_of(rendered_lines(model, "iso", 200, true).lines);
    ASSERT_EQ(fast.size(), slow.size());
    for (const auto& [kind, length] : slow) EXPECT_NEAR(fast.at(kind), length, 0.01f * length);
}

}  // namespace
}  // namespace slim
