#include "raytrace/lines/creases.h"

#include "raytrace/brute/brute_renderer.h"
#include "raytrace/crop.h"
#include "raytrace/lines/extract.h"
#include "raytrace/lines/line_search.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/lines/select.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/parallel.h"
#include "slim/edges/trace_edges.h"
#include "tests/raytrace/support/sharp_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace slim {
namespace {

using test::axis_vector, test::cube_leaves, test::edge_surfel, test::flat_tree;

constexpr int kSize = 300;
const std::vector<LineKind> kCreases{LineKind::convex_crease, LineKind::concave_crease};

Camera camera_at(const Vec3d& eye, double width = 0) {
    Camera camera;
    camera.eye = eye, camera.up = {0, 0, 1};
    camera.orthographic = width > 0;
    if (width > 0) camera.width = width;
    return camera;
}

struct Drawn {
    GBuffer buffer;
    std::vector<FeatureLine> lines;
};
Drawn drawn(const SurfelTreeData& model, const std::vector<SharpEdge>& edges, const Camera& camera,
            bool brute = false, std::vector<LineKind> kinds = kCreases) {
    RenderRequest request;
    request.camera = camera, request.width = request.height = kSize, request.lod_px = 0;
    request.wanted = line_channels(kinds, model.header.degree);
    Drawn out;
    if (brute)
        render_brute(model.view(), request, out.buffer);
    else
        render_forward(model.view(), request, out.buffer);
    out.lines = extract_lines({out.buffer, pixel_view(camera, kSize, kSize), model.header.diagonal,
                               model.header.degree, edges},
                              kinds);
    return out;
}

Vec3d pixel_of(const Camera& camera, const Vec3d& p) {
    const PixelView view = pixel_view(camera, kSize, kSize);
    const Vec3d c = view.camera_from_local(p);
    const double scale = view.orthographic ? view.px_per_unit : view.focal_px / c.z;
    return {view.center_x + scale * c.x, view.center_y + scale * c.y, 0};
}

/// The twelve edges of the cube [-1, 1]^3.
struct CubeEdge {
    Vec3d a, b;
    std::array<Vec3d, 2> normal;
};
std::vector<CubeEdge> cube_edges() {
    std::vector<CubeEdge> out;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double s : {-1.0, 1.0})
            for (const double t : {-1.0, 1.0}) {
                const Vec3d u = axis_vector((axis + 1) % 3, s), v = axis_vector((axis + 2) % 3, t);
                out.push_back({u + v - axis_vector(axis, 1), u + v + axis_vector(axis, 1), {u, v}});
            }
    return out;
}

double off_segment(const LinePoint& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d q{p.x, p.y, 0}, d = b - a;
    return length(q - a - d * std::clamp(dot(q - a, d) / dot(d, d), 0.0, 1.0));
}

double length_px(const std::vector<FeatureLine>& lines) {
    double sum = 0;
    for (const FeatureLine& line : lines) sum += static_cast<double>(line.length_px);
    return sum;
}

TEST(Creases, AreTheSameInBandsOfRows) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Camera camera = camera_at({3, 4, 5});
    const Drawn whole = drawn(model, edges, camera);
    ASSERT_GT(whole.lines.size(), 5u);
    const PixelView view = pixel_view(camera, kSize, kSize);
    for (const int n_rows : {32, 77}) {
        LineSearch search(kCreases);
        for (int y = 0; y < kSize; y += n_rows) {
            const int end = std::min(kSize, y + n_rows), margin = line_margin(kSize, kSize);
            const int top = std::max(0, y - margin), bottom = std::min(kSize, end + margin);
            const GBuffer part = crop(whole.buffer, {0, top, kSize, bottom - top});
            search.add(
                {part, view, model.header.diagonal, 2, edges, {top, kSize, y - top, end - top}});
        }
        EXPECT_EQ(lines_ply(search.finish(), {}), lines_ply(whole.lines, {})) << n_rows;
    }
}

TEST(Creases, OfACubeAreItsSeenEdgesToAFewHundredthsOfAPixel) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    for (const Camera& camera :
         {camera_at({3, 4, 5}), camera_at({6, -2, 3}, 4.5), camera_at({-5, 0.5, 0.4}, 4.5)}) {
        double seen = 0;
        std::vector<std::array<Vec3d, 2>> truth;
        for (const CubeEdge& e : cube_edges()) {
            const Vec3d eye = camera.orthographic ? camera.eye * 1e6 : camera.eye;
            if (std::max(dot(e.normal[0], eye), dot(e.normal[1], eye)) <= 1) continue;
            truth.push_back({pixel_of(camera, e.a), pixel_of(camera, e.b)});
            seen += length(truth.back()[1] - truth.back()[0]);
        }
        ASSERT_EQ(truth.size(), 9u);
        const auto lines = drawn(model, edges, camera).lines;
        EXPECT_EQ(lines.size(), 9u);
        // the last pixel before a corner may not be seen
        EXPECT_NEAR(length_px(lines), seen, 9 * 2);
        for (const FeatureLine& line : lines) {
            EXPECT_EQ(line.kind, LineKind::convex_crease);
            EXPECT_NEAR(line.strength, 90, 0.1);
            for (const LinePoint& p : line.points) {
                double off = kSize;
                for (const auto& [a, b] : truth) off = std::min(off, off_segment(p, a, b));
                EXPECT_LT(off, 0.02);
            }
        }
    }
}

TEST(Creases, TellHowFarTheFaceIsTurnedThatIsTurnedAwayMost) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Camera camera = camera_at({6, -2, 3}, 4.5);
    std::size_t n_turned = 0, n_seen = 0;
    for (const FeatureLine& line : drawn(model, edges, camera).lines)
        for (const LinePoint& p : line.points) {
            const Vec3f& at = p.point;
            if (std::min({std::fabs(at.x), std::fabs(at.y), std::fabs(at.z)}) > 0.98f)
                continue;  // at a corner, where three edges are
            double facing = 1, off = kSize;
            for (const CubeEdge& e : cube_edges()) {
                const Vec3d d = e.b - e.a, q = to_double(p.point) - e.a;
                const double here = length(q - d * (dot(q, d) / dot(d, d)));
                const Vec3d to_eye = normalized(camera.eye);
                if (here < off)
                    off = here, facing = std::min(dot(e.normal[0], to_eye),
                                                  dot(e.normal[1], to_eye));
            }
            EXPECT_NEAR(p.facing, facing, 0.01);
            EXPECT_EQ(p.weight, 0);
            ++(facing < 0 ? n_turned : n_seen);
        }
    EXPECT_GT(n_turned, 100u);
    EXPECT_GT(n_seen, 100u);
}

TEST(Creases, InTheBruteRenderersPictureAreTheSame) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Camera camera = camera_at({3, 4, 5});
    const auto fast = drawn(model, edges, camera).lines,
               slow = drawn(model, edges, camera, true).lines;
    ASSERT_EQ(fast.size(), slow.size());
    for (std::size_t i = 0; i < fast.size(); ++i)
        EXPECT_NEAR(fast[i].length_px, slow[i].length_px, 2);
}

TEST(Creases, BehindASurfaceAreHidden) {
    // A wall between the eye and the lower half of the cube's edge at x = y = 1.
    std::vector<Surfel> leaves = cube_leaves();
    for (const double s : {-0.5, 0.0, 0.5})
        for (const double t : {-1.5, -1.0, -0.55})
            leaves.push_back(test::plane_surfel(Vec3d{2, 2, t} + Vec3d{s, -s, 0}, {1, 1, 0}, 0.75));
    const SurfelTreeData model = flat_tree(leaves, 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Drawn d = drawn(model, edges, camera_at({5, 5, 0.001}, 4.5));
    // The wall ends at z = -0.55 + 0.72 * 0.75 at the latest, on the axis.
    float lowest = 1, highest = -1;
    for (const FeatureLine& line : d.lines)
        for (const LinePoint& p : line.points)
            if (p.point.x > 0.999f && p.point.y > 0.999f)
                lowest = std::min(lowest, p.point.z), highest = std::max(highest, p.point.z);
    EXPECT_GT(lowest, -0.2f);
    EXPECT_LT(lowest, 0.1f);
    EXPECT_GT(highest, 0.98f);
}

TEST(Creases, OfALeafThatAFaceRunsOverAreNotDrawn) {
    // As beyond a corner that no leaf of three sheets has:
    // its second sheet goes down inside the cube.
    std::vector<Surfel> leaves = cube_leaves();
    leaves.push_back(edge_surfel({0, 0, 1}, {0, 0, 1}, {1, 0, 0}, 0.4));
    leaves.push_back(edge_surfel({0, 0.2, 1}, {0, 0, 1}, {1, 0, 0}, 0.4));
    const SurfelTreeData model = flat_tree(leaves, 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    ASSERT_EQ(edges.size(), 13u);
    for (const FeatureLine& line : drawn(model, edges, camera_at({3, 4, 5})).lines)
        for (const LinePoint& p : line.points)
            EXPECT_GT(std::abs(p.point.x) + std::abs(p.point.y), 0.9f);
}

TEST(Creases, StayInThePictureHoweverNear) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    Camera camera = camera_at({1.002, 1.002, 0.3});
    camera.target = {1, 1, 0.301};
    const auto lines = drawn(model, edges, camera).lines;
    ASSERT_FALSE(lines.empty());
    EXPECT_GT(length_px(lines), kSize / 2);
    EXPECT_LT(length_px(lines), 3 * kSize);
    for (const FeatureLine& line : lines)
        for (const LinePoint& p : line.points) {
            ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && is_finite(p.point));
            EXPECT_TRUE(p.x >= 0 && p.y >= 0 && p.x <= kSize && p.y <= kSize);
        }
    for (const FeatureLine& line : lines)
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            EXPECT_LT(std::hypot(line.points[i + 1].x - line.points[i].x,
                                 line.points[i + 1].y - line.points[i].y),
                      1.01f);
}

TEST(Creases, OfAHollowAreOfTheirOwnKind) {
    std::vector<Surfel> leaves;
    for (const double t : {-0.6, -0.3, 0.0, 0.3, 0.6})
        leaves.push_back(edge_surfel({t, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.4, Join::min));
    const SurfelTreeData model = flat_tree(leaves, 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const auto lines = drawn(model, edges, camera_at({0, 3, 3}, 3)).lines;
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].kind, LineKind::concave_crease);
    EXPECT_NEAR(lines[0].length, 1.2 + 2 * kHitTrim * 0.4, 0.08);
}

TEST(Creases, OfSmallTurnAreDrawnOnlyBesideStrongOnes) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    auto edges = trace_sharp_edges(model.view(), false);
    const auto lines_of = [&] { return drawn(model, edges, camera_at({3, 4, 5})).lines.size(); };
    ASSERT_EQ(lines_of(), 9u);
    // as if its second face bent away from the first
    const auto flatten = [](SharpEdge& e, float degrees) {
        const float a = degrees * std::numbers::pi_v<float> / 180;
        for (EdgePoint& p : e.points)
            p.normal[1] = p.normal[0] * std::cos(a) + p.normal[1] * std::sin(a);
    };
    auto all = edges;
    for (SharpEdge& e : edges) flatten(e, 22);
    EXPECT_EQ(lines_of(), 0u);
    edges = all;
    for (std::size_t i = 1; i < edges.size(); ++i) flatten(edges[i], 22);
    EXPECT_GE(lines_of(),
              // linked by corners to the one that is left; a face's own edges may look as if it ran
              // on
              8u);
    for (std::size_t i = 1; i < edges.size(); ++i) edges[i].corner = {kNoCorner, kNoCorner};
    EXPECT_LE(lines_of(), 1u);
}

TEST(Creases, OfOneLeafAloneOrOfFewPixelsAreDropped) {
    const SurfelTreeData one = flat_tree({edge_surfel({}, {0, 0, 1}, {0, 1, 0}, 0.4)}, 2);
    EXPECT_TRUE(
        drawn(one, trace_sharp_edges(one.view(), false), camera_at({0, 3, 3}, 1)).lines.empty());
    const SurfelTreeData two = flat_tree({edge_surfel({}, {0, 0, 1}, {0, 1, 0}, 0.4),
                                          edge_surfel({0.2, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.4)},
                                         2);
    const auto edges = trace_sharp_edges(two.view(), false);
    const float least = line_rules(LineKind::convex_crease, kSize, kSize).least_px;
    const double length = 0.2 + 2 * kHitTrim * 0.4;
    EXPECT_EQ(drawn(two, edges, camera_at({0, 3, 3}, 1)).lines.size(), 1u);
    EXPECT_TRUE(
        drawn(two, edges, camera_at({0, 3, 3}, length * kSize / static_cast<double>(least - 1)))
            .lines.empty());
}

TEST(Creases, AreTheSameForAnyNumberOfThreads) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const auto with = [&](int threads) {
        const ThreadLimit limit(threads);
        return lines_ply(drawn(model, edges, camera_at({3, 4, 5})).lines, {});
    };
    const std::string one = with(1);
    EXPECT_EQ(one, with(2));
    EXPECT_EQ(one, with(5));
}

TEST(Creases, TakeTheirEdgesFromCrestLines) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 3);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Camera camera = camera_at({3, 4, 5});
    const auto crest = drawn(model, edges, camera, false, {LineKind::ridge}).lines;
    EXPECT_GT(length_px(crest), 200);  // the three edges between seen faces
    const auto both =
        drawn(model, edges, camera, false, {LineKind::ridge, LineKind::convex_crease}).lines;
    EXPECT_TRUE(std::none_of(both.begin(), both.end(),
                             [](const FeatureLine& l) { return l.kind == LineKind::ridge; }));
    EXPECT_EQ(both.size(), 9u);
    // Found by searches of their own, as of one model of several.
    const Drawn view =
        drawn(model, edges, camera, false, {LineKind::ridge, LineKind::convex_crease});
    const PixelView pixels = pixel_view(camera, kSize, kSize);
    LineSearch ridges(std::vector{LineKind::ridge}), creases(std::vector{LineKind::convex_crease});
    ridges.add({view.buffer, pixels, model.header.diagonal, 3});
    creases.add({view.buffer, pixels, model.header.diagonal, 3, edges});
    EXPECT_TRUE(ridges.finish(creases.finish()).empty());
}

TEST(Creases, AndContoursAreOneStrokeForEachEdge) {
    const SurfelTreeData model = flat_tree(cube_leaves(), 2);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Camera camera = camera_at({3, 4, 5});
    const auto both =
        drawn(model, edges, camera, false, {LineKind::convex_crease, LineKind::contour}).lines;
    // All edges of a cube that are seen are creases: together they are drawn once.
    EXPECT_NEAR(length_px(both), length_px(drawn(model, edges, camera).lines), 12);
    std::size_t n_outlines = 0;
    for (const FeatureLine& line : both) {
        if (line.kind != LineKind::contour) continue;
        ++n_outlines;
        EXPECT_TRUE(line.closed);
        for (const LinePoint& p : line.points) {
            double off = 1e9;
            for (const CubeEdge& edge : cube_edges())
                off = std::min(
                    off, off_segment(p, pixel_of(camera, edge.a), pixel_of(camera, edge.b)));
            EXPECT_LT(off, 0.1);  // contours from pixels: 0.5
        }
    }
    EXPECT_EQ(n_outlines, 1u);
}

/// The cube, and one beside it whose edges no sharp leaf has: only the picture shows them,
/// as crest lines.
std::vector<Surfel> cube_beside_a_plain_one() {
    std::vector<Surfel> leaves = cube_leaves();
    const std::size_t n = leaves.size();
    const Vec3d beside{-1.6, 2.4, -0.3};
    for (std::size_t i = 0; i < n; ++i)
        if (leaves[i].n_sheets() == 1) {
            Surfel s = leaves[i];
            s.center += beside, s.support_radius = 0.6;  // the faces meet
            leaves.push_back(s);
        }
    return leaves;
}

TEST(Creases, AndCrestLinesAreTheSameInBandsOfRows) {
    const SurfelTreeData model = flat_tree(cube_beside_a_plain_one(), 3);
    const auto edges = trace_sharp_edges(model.view(), false);
    const Camera camera = camera_at({5, 6, 7});
    const std::vector<LineKind> kinds{LineKind::valley, LineKind::ridge, LineKind::convex_crease,
                                      LineKind::concave_crease, LineKind::contour};
    const auto length_of = [&](const std::vector<FeatureLine>& lines, LineKind kind) {
        double sum = 0;
        for (const FeatureLine& line : lines)
            sum += line.kind == kind ? static_cast<double>(line.length_px) : 0;
        return sum;
    };
    const Drawn whole = drawn(model, edges, camera, false, kinds);
    const auto crest = drawn(model, {}, camera, false, kinds).lines;
    // Some crest lines give way, others stay.
    EXPECT_GT(length_of(whole.lines, LineKind::convex_crease), 200);
    EXPECT_GT(length_of(whole.lines, LineKind::ridge), 20);
    EXPECT_GT(length_of(crest, LineKind::ridge), length_of(whole.lines, LineKind::ridge) + 100);
    const PixelView view = pixel_view(camera, kSize, kSize);
    for (const int n_rows : {32, 77, 128}) {
        LineSearch search(kinds);
        for (int y = 0; y < kSize; y += n_rows) {
            const int end = std::min(kSize, y + n_rows), margin = line_margin(kSize, kSize);
            const int top = std::max(0, y - margin), bottom = std::min(kSize, end + margin);
            const GBuffer part = crop(whole.buffer, {0, top, kSize, bottom - top});
            search.add(
                {part, view, model.header.diagonal, 3, edges, {top, kSize, y - top, end - top}});
        }
        EXPECT_EQ(lines_ply(search.finish(), {}), lines_ply(whole.lines, {})) << n_rows;
    }
}

}  // namespace
}  // namespace slim
