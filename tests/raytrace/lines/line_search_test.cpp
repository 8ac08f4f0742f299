#include "raytrace/lines/line_search.h"

#include "raytrace/crop.h"
#include "raytrace/lines/extract.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/lines/lines_svg.h"
#include "raytrace/lines/stroke.h"
#include "raytrace/project/forward_renderer.h"
#include "tests/raytrace/lines/analytic_buffer.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

// Lines that are found and drawn band by band are those of the whole picture, to the bit.

namespace slim {
namespace {

/// A frame of a whole picture, with the planes of every kind of line.
struct View {
    GBuffer buffer;
    PixelView pixels;
    double diagonal;
    int degree;
};

View view_of(const SurfelTreeData& model, const Camera& camera, int width, int height) {
    RenderRequest request;
    request.camera = camera;
    request.width = width, request.height = height;
    request.wanted = line_channels(kAllLineKinds, model.header.degree) | kDirectionChannel;
    request.lod_px = 0;
    View view{
        {}, pixel_view(request.camera, width, height), model.header.diagonal, model.header.degree};
    render_forward(model.view(), request, view.buffer);
    return view;
}

/// The torus from that side, all of it in the picture.
View torus_view(int degree, const Vec3d& side, int width, int height) {
    Camera camera;
    camera.eye = side * (4.2 / length(side)), camera.up = {0, 0, 1};
    return view_of(test::torus_model(1, 0.35, 90, 36, degree), camera, width, height);
}

View ellipsoid_view(int size) {
    const Camera camera = test::camera_from_x(1.6);
    return {test::ellipsoid_buffer(camera, size, {1, 0.7, 0.4}), pixel_view(camera, size, size),
            2.6, 3};
}

/// The same seen from within: ridges are valleys.
View hollow_view(int size) {
    View view = ellipsoid_view(size);
    test::turn_inside_out(view.buffer);
    return view;
}

/// The roof of two planes at a right angle: an edge within a pixel, slanted across all bands.
View roof_view(int size) {
    const Camera camera = test::camera_from_x(size);
    View view{{}, pixel_view(camera, size, size), 2.0 * size, 3};
    GBuffer& b = view.buffer;
    b.reset(size, size, kAllChannels);
    const Vec3f across{0, std::sqrt(0.8f), std::sqrt(0.2f)};
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const std::size_t i = b.index(x, y);
            const Vec3f p = to_float(view.pixels.point_at(x + 0.5, y + 0.5, 10));
            const float side = dot(p, across) - 0.123f;
            const Vec3f n =
                Vec3f{1, 0, 0} * std::sqrt(0.5f) + across * std::copysign(std::sqrt(0.5f), side);
            b.hit[i] = 1;
            b.position[0][i] = -std::fabs(side), b.position[1][i] = p.y, b.position[2][i] = p.z;
            for (std::size_t axis = 0; axis < 3; ++axis) b.normal[axis][i] = n[axis];
        }
    return view;
}

/// Waves that run aslant, seen from above: their inflections are suggestive contours.
View waves_view(int size) {
    const Camera camera = test::camera_from_x(size);
    View view{{}, pixel_view(camera, size, size), 2.0 * size, 3};
    GBuffer& b = view.buffer;
    b.reset(size, size, kAllChannels);
    const Vec3f across{0, std::sqrt(0.8f), std::sqrt(0.2f)}, along = cross(Vec3f{1, 0, 0}, across);
    const float w = 0.1f, a = 10;  // height a cos(w s): 45 degrees at its steepest
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const std::size_t i = b.index(x, y);
            const Vec3f p = to_float(view.pixels.point_at(x + 0.5, y + 0.5, 10));
            const float c = std::cos(w * dot(p, across)), s = std::sin(w * dot(p, across));
            const float slope = -a * w * s, sq = 1 + slope * slope,
                        k = a * w * w * c / std::pow(sq, 1.5f);
            const Vec3f t = (across + Vec3f{slope, 0, 0}) * (1 / std::sqrt(sq)),
                        n = cross(t, along);
            // dk/ds over the length of an arc; k'' of the height is -w^2 of its slope.
            const float rise =
                (w * w * slope / std::pow(sq, 1.5f) + 3 * k * slope * a * w * w * c / sq) /
                std::sqrt(sq);
            const Vec3f normal = n.x > 0 ? n : n * -1.0f, t1 = k > 0 ? t : along;
            b.hit[i] = 1, b.k1[i] = std::max(k, 0.0f), b.k2[i] = std::min(k, 0.0f);
            b.gauss[i] = 0;
            const float sign = k > 0 ? 1.0f : dot(cross(normal, t1), t);
            b.third[k > 0 ? 0 : 3][i] = sign * rise;
            b.position[0][i] = a * c, b.position[1][i] = p.y, b.position[2][i] = p.z;
            for (std::size_t axis = 0; axis < 3; ++axis)
                b.normal[axis][i] = normal[axis], b.direction[axis][i] = t1[axis];
        }
    return view;
}

std::vector<std::pair<std::string, View>> all_views() {
    std::vector<std::pair<std::string, View>> views;
    views.emplace_back("torus, quadratic", torus_view(2, {1, -1, 1}, 360, 410));
    views.emplace_back("torus, cubic", torus_view(3, {1, -1, 1}, 301, 515));
    views.emplace_back("torus from its side", torus_view(3, {4, 0, 1.2}, 520, 420));
    views.emplace_back("ellipsoid", ellipsoid_view(330));
    views.emplace_back("ellipsoid, looked at in every second pixel", ellipsoid_view(820));
    views.emplace_back("hollow", hollow_view(330));
    views.emplace_back("roof", roof_view(290));
    views.emplace_back("waves", waves_view(310));
    views.emplace_back("waves, by differences", waves_view(310));
    views.back().second.degree = 2;  // crest lines ask for planes, not for a degree
    return views;
}

std::vector<FeatureLine> whole_lines(const View& view) {
    return extract_lines({view.buffer, view.pixels, view.diagonal, view.degree}, kAllLineKinds);
}

/// The same, searched in bands of so many rows, each held with nothing but its margin.
std::vector<FeatureLine> lines_in_bands(const View& view, int n_rows) {
    const int width = view.buffer.width, height = view.buffer.height,
              margin = line_margin(width, height);
    LineSearch search(kAllLineKinds);
    for (int y = 0; y < height; y += n_rows) {
        const int end = std::min(height, y + n_rows);
        const int top = std::max(0, y - margin), bottom = std::min(height, end + margin);
        const GBuffer part = crop(view.buffer, {0, top, width, bottom - top});
        search.add(
            {part, view.pixels, view.diagonal, view.degree, {}, {top, height, y - top, end - top}});
    }
    return search.finish();
}

/// All that is known of lines, to the bit.
std::string bytes_of(const std::vector<FeatureLine>& lines) {
    std::string bytes;
    const auto put = [&](float v) { bytes.append(reinterpret_cast<const char*>(&v), sizeof v); };
    for (const FeatureLine& line : lines) {
        bytes += std::string(line_name(line.kind)) + (line.closed ? "o" : "-");
        put(line.length), put(line.length_px), put(line.strength);
        for (const LinePoint& p : line.points)
            put(p.x), put(p.y), put(p.point.x), put(p.point.y), put(p.point.z), put(p.weight),
                put(p.evidence);
    }
    return bytes;
}

TEST(LineSearch, BandsGiveTheLinesOfTheWholeToTheBit) {
    std::set<LineKind> seen;
    for (const auto& [name, view] : all_views()) {
        SCOPED_TRACE(name);
        const auto whole = whole_lines(view);
        for (const FeatureLine& line : whole) seen.insert(line.kind);
        for (const int n_rows : {32, 61, 128})
            ASSERT_EQ(bytes_of(lines_in_bands(view, n_rows)), bytes_of(whole)) << n_rows;
    }
    for (const LineKind kind : kAllLineKinds)
        // creases: creases_test
        EXPECT_NE(seen.contains(kind), is_crease(kind)) << line_name(kind);
}

TEST(LineSearch, APictureOfPartsIsThePicture) {
    const View view = torus_view(3, {1, -1, 1}, 301, 215);
    const auto lines = whole_lines(view);
    Picture whole(301, 215);
    for (float& v : whole.rgba) v = 0.5f;
    draw_lines(lines, whole);
    const PixelWindow all{0, 0, 301, 215};
    const std::vector<LineKind> kinds{LineKind::contour, LineKind::parabolic};
    const auto strength = strength_plane(lines, kinds, 301, 215, all);
    for (const PixelWindow w : {PixelWindow{0, 0, 301, 70}, {0, 70, 301, 145}, {33, 41, 97, 101}}) {
        Picture part(w.width, w.height);
        for (float& v : part.rgba) v = 0.5f;
        draw_lines(lines, {part, w.x, w.y, 301, 215});
        EXPECT_EQ(part.rgba, crop(whole, w).rgba);
        draw_lines(lines_within(lines, 301, 215, w),
                   {part = Picture(w.width, w.height), w.x, w.y, 301, 215});
        Picture empty(301, 215);
        draw_lines(lines, empty);
        EXPECT_EQ(part.rgba, crop(empty, w).rgba);
        EXPECT_EQ(strength_plane(lines, kinds, 301, 215, w), crop(strength, 301, w));
    }
}

TEST(LinesWithin, AreThoseThatTouchTheWindow) {
    const auto line = [](float y) {
        return FeatureLine{
            LineKind::contour, false, {{10, y, {}, 1, 1}, {90, y, {}, 1, 1}}, 1, 80, 1};
    };
    const std::vector<FeatureLine> lines{line(10), line(50.9f), line(90)};
    // a stroke of 1.8 pixels reaches into it
    const auto within = lines_within(lines, 1000, 1000, {0, 52, 100, 20});
    ASSERT_EQ(within.size(), 1u);
    EXPECT_EQ(within[0].points[0].y, 50.9f);
    const std::string svg =
        lines_svg(within, std::vector{LineKind::contour}, 1000, 1000, {0, 52, 100, 20});
    EXPECT_NE(svg.find("width=\"26.458mm\" height=\"5.292mm\" viewBox=\"0 13.758 26.458 5.292\""),
              std::string::npos)
        << svg;
}

}  // namespace
}  // namespace slim
