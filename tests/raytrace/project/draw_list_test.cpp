#include "raytrace/project/draw_list.h"

#include "raytrace/project/lod_cut.h"
#include "raytrace/project/tile_bins.h"
#include "slim/base/error.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace slim {
namespace {

double uniform(std::uint64_t seed, std::uint64_t i) {
    return 2 * unit_interval(keyed_hash(seed, i)) - 1;
}

/// True if the ray of the pixel meets the ball at or behind the near plane.
bool ray_meets(const PixelView& view, int x, int y, const Vec3d& center, double radius) {
    const Vec3d o = view.camera_from_local(view.ray_origin(x + 0.5, y + 0.5));
    const Vec3d d = view.rotate_to_camera(view.ray_direction(x + 0.5, y + 0.5));
    const double foot = dot(center - o, d);
    const double sq_half = radius * radius - sq_length(o + d * foot - center);
    return sq_half > 0 && (foot + std::sqrt(sq_half)) * d.z >= view.near_plane;
}

TEST(ScreenRect, HoldsEveryPixelOfTheBallAndIsTightInFrontOfTheCamera) {
    const int size = 60;
    for (const double fov : {0.001, 35.0, 120.0, 179.0})
        for (const bool orthographic : {false, true})
            for (std::uint64_t seed = 0; seed < 60; ++seed) {
                SCOPED_TRACE(testing::Message() << fov << ' ' << orthographic << ' ' << seed);
                Camera camera;
                camera.fov_y_deg = fov, camera.orthographic = orthographic,
                camera.near_plane = 0.05;
                camera.width = 2;
                const PixelView view = pixel_view(camera, size, size);
                const double z = 1.5 * (1 + uniform(seed, 0)) - 0.2;
                const double spread = orthographic ? 1 : std::abs(z) * std::tan(fov * 0.0087);
                const Vec3d c{spread * uniform(seed, 1), spread * uniform(seed, 2), z};
                const double radius = 0.4 * spread * unit_interval(keyed_hash(seed, 3));
                const ScreenRect r = screen_rect(view, {0, 0, size, size}, c, radius);
                ScreenRect true_rect{size, size, 0, 0};
                for (int y = 0; y < size; ++y)
                    for (int x = 0; x < size; ++x) {
                        if (!ray_meets(view, x, y, c, radius)) continue;
                        true_rect = {std::min(true_rect.x0, x), std::min(true_rect.y0, y),
                                     std::max(true_rect.x1, x + 1), std::max(true_rect.y1, y + 1)};
                        ASSERT_TRUE(x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1)
                            << x << ' ' << y;
                    }
                if (true_rect.empty() || z <= 2 * radius || z < 0.1 + radius) continue;
                // An extreme of the outline may lie between pixel centres:
                // two pixels for a round one.
                EXPECT_GE(r.x0, true_rect.x0 - 3);
                EXPECT_LE(r.x1, true_rect.x1 + 3);
            }
}

TEST(ViewVolume, NeverCullsABallThatAPixelSees) {
    const int size = 40;
    int culled = 0;
    for (const bool orthographic : {false, true})
        for (std::uint64_t seed = 0; seed < 300; ++seed) {
            Camera camera;
            camera.orthographic = orthographic, camera.fov_y_deg = 70, camera.width = 2;
            camera.near_plane = 0.1;
            const PixelView view = pixel_view(camera, size, size);
            const PixelWindow window{10, 5, 20, 15};
            const Vec3d c{2 * uniform(seed, 1), 2 * uniform(seed, 2), 2 * uniform(seed, 3)};
            const double radius = 0.5 * unit_interval(keyed_hash(seed, 4));
            if (ViewVolume(view, window).may_see(c, radius)) continue;
            ++culled;
            for (int y = window.y; y < window.y + window.height; ++y)
                for (int x = window.x; x < window.x + window.width; ++x)
                    ASSERT_FALSE(ray_meets(view, x, y, c, radius)) << seed;
        }
    EXPECT_GT(culled, 100);
}

TEST(LodCut, DescendsWhileTheProjectedBallIsLarger) {
    const auto model = test::two_level_sphere(1, 100, 900);
    Camera camera;
    camera.orthographic = true, camera.width = 4, camera.eye = {0, 0, 5};
    const PixelView view = pixel_view(camera, 400, 400);
    const double diameter = 2 * model.view().support_radius(1) * view.px_per_unit;
    CutCounts met;
    const PixelWindow window{0, 0, 400, 400};
    EXPECT_EQ(lod_cut(model.view(), view, window, {diameter * 1.01, false}, met).size(), 100u);
    EXPECT_EQ(met.nodes_visited, 101u);
    EXPECT_EQ(lod_cut(model.view(), view, window, {diameter * 0.99, false}, met).size(), 900u);
    EXPECT_EQ(lod_cut(model.view(), view, window, {0, false}, met).size(), 900u);
}

TEST(LodCut, TakesTheLeavesThatAWindowSees) {
    const auto data = test::two_level_sphere(1, 100, 900);
    const SurfelTree tree = data.view();
    for (const bool orthographic : {false, true}) {
        Camera camera;
        camera.orthographic = orthographic, camera.width = 4, camera.eye = {0, 0, 5};
        const PixelView view = pixel_view(camera, 400, 400);
        for (const PixelWindow window : {PixelWindow{0, 0, 400, 400},
                                         {0, 0, 200, 130},
                                         {150, 150, 60, 60},
                                         {190, 100, 3, 3}}) {
            std::vector<std::uint32_t> seen;
            for (std::uint32_t i = 1; i < tree.n_nodes(); ++i)
                if (tree.node(i).is_leaf() &&
                    ViewVolume(view, window)
                        .may_see(view.camera_from_local(tree.center(i)), tree.support_radius(i)))
                    seen.push_back(i);
            CutCounts met;
            std::vector<std::uint32_t> visited;
            met.visited = &visited;
            auto cut = lod_cut(tree, view, window, {0, false}, met);
            EXPECT_EQ(visited.size(), met.nodes_visited);
            std::sort(cut.begin(), cut.end());
            EXPECT_EQ(cut, seen) << window.width;
            CutCounts again;  // where nobody asks for the nodes
            EXPECT_EQ(lod_cut(tree, view, window, {0, false}, again).size(), seen.size());
            EXPECT_EQ(again.nodes_visited, met.nodes_visited);
        }
    }
}

TEST(LodCut, OfAPartIsInTheOrderOfTheWholeAndNamesASharedChild) {
    // Generations so large that they are gone through in parallel.
    auto data = test::two_level_sphere(1, 60, 9000);
    Camera camera;
    camera.orthographic = true, camera.width = 4, camera.eye = {0, 0, 5};
    const PixelView view = pixel_view(camera, 400, 400);
    CutCounts met;
    const auto whole = lod_cut(data.view(), view, {0, 0, 400, 400}, {0, false}, met);
    EXPECT_EQ(whole.size(), 9000u);
    EXPECT_TRUE(std::is_sorted(whole.begin(), whole.end()));  // as the file holds them
    for (const PixelWindow window : {PixelWindow{0, 0, 150, 400}, {120, 130, 100, 60}}) {
        const auto part = lod_cut(data.view(), view, window, {0, false}, met);
        EXPECT_LT(part.size(), 6000u);
        EXPECT_GT(part.size(), 100u);
        EXPECT_TRUE(std::includes(whole.begin(), whole.end(), part.begin(), part.end()));
    }
    // All after the sixth's children are those of the seventh as well.
    data.nodes[7].first_child = data.nodes[6].first_child;
    data.nodes[7].n_children =
        static_cast<std::uint32_t>(data.nodes.size()) - data.nodes[6].first_child;
    try {
        lod_cut(data.view(), view, {0, 0, 400, 400}, {0, false}, met);
        FAIL();
    } catch (const FormatError& e) {
        const std::string child = std::to_string(data.nodes[6].first_child);
        EXPECT_EQ(std::string(e.what()), "tree node " + child + ": has another parent too");
    }
}

TEST(LodCut, LeavesLooseSurfelsOutUnlessAsked) {
    auto model = test::two_level_sphere(1, 100, 900);
    const auto first = model.nodes[1].first_child;
    for (std::uint32_t c = 0; c < model.nodes[1].n_children; ++c)
        model.nodes[first + c].flags |= kLoose;
    model.nodes[1].flags |= kLoose;
    const std::size_t loose = model.nodes[1].n_children;
    Camera camera;
    camera.orthographic = true, camera.width = 4, camera.eye = {0, 0, 5};
    const PixelView view = pixel_view(camera, 400, 400);
    const double diameter = 2 * model.view().support_radius(1) * view.px_per_unit;
    const auto cut = [&](double lod_px, bool wanted, CutCounts& met) {
        return lod_cut(model.view(), view, {0, 0, 400, 400}, {lod_px, wanted}, met).size();
    };
    CutCounts leaves, coarse, all;
    EXPECT_EQ(cut(0, false, leaves), 900u - loose);
    EXPECT_EQ(leaves.loose_hidden, loose);
    EXPECT_EQ(cut(diameter * 1.01, false, coarse), 99u);
    EXPECT_EQ(coarse.loose_hidden, 1u);
    EXPECT_EQ(cut(0, true, all), 900u);
    EXPECT_EQ(all.loose_hidden, 0u);
}

TEST(LodCut, Row44RefusesACycle) {
    auto model = test::two_level_sphere(1, 10, 40);
    model.nodes[3].first_child = 2;
    Camera camera;
    camera.eye = {0, 0, 5};
    CutCounts met;
    const PixelView view = pixel_view(camera, 50, 50);
    EXPECT_THROW(lod_cut(model.view(), view, {0, 0, 50, 50}, {0, false}, met), FormatError);
    model.nodes[3].first_child = 49;
    EXPECT_THROW(lod_cut(model.view(), view, {0, 0, 50, 50}, {0, false}, met), FormatError);
}

TEST(DrawList, IsSortedByTheNearEndOfTheTrimmedPatch) {
    const auto model = test::sphere_model(1, 500);
    Camera camera;
    camera.eye = {0, 0, 5};
    const PixelView view = pixel_view(camera, 50, 50);
    CutCounts met;
    const PixelWindow window{0, 0, 50, 50};
    const auto cut = lod_cut(model.view(), view, window, {0, false}, met);
    const auto list = draw_list<2>(view, window, model.view(), cut);
    // A patch seen from its edge may lie between the pixels.
    ASSERT_GE(list.order.size(), 480u);
    for (std::size_t i = 1; i < list.order.size(); ++i)
        ASSERT_LE(list.items[list.order[i - 1]].near_hit,
                  list.items[list.order[i]].near_hit + 1e-6);
}

TEST(TileBins, HoldEachRectInItsTilesInOrder) {
    const PixelWindow window{5, 7, 100, 70};
    const std::vector<ScreenRect> rects{{5, 7, 6, 8}, {36, 38, 38, 40}, {5, 7, 105, 77}};
    const std::vector<std::uint32_t> order{0, 1, 2};
    const TileBins bins = tile_bins(window, rects, order);
    EXPECT_EQ(bins.columns, 4);
    EXPECT_EQ(bins.rows, 3);
    const auto of = [&](std::size_t t) {
        return std::vector<std::uint32_t>(bins.of(t).begin(), bins.of(t).end());
    };
    EXPECT_EQ(of(0), (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(of(1), (std::vector<std::uint32_t>{1, 2}));
    EXPECT_EQ(of(4), (std::vector<std::uint32_t>{1, 2}));
    EXPECT_EQ(of(11), (std::vector<std::uint32_t>{2}));
}

TEST(TileBins, KeepTheOrderOfManyRectangles) {
    const PixelWindow window{0, 0, 320, 200};
    std::vector<ScreenRect> rects;
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < 20000; ++i) {
        const int x = static_cast<int>(keyed_hash(1, i) % 300),
                  y = static_cast<int>(keyed_hash(2, i) % 180);
        rects.push_back({x, y, x + 1 + static_cast<int>(i % 20), y + 1 + static_cast<int>(i % 17)});
        if (i % 3) order.push_back((i * 7919) % 20000);
    }
    const TileBins bins = tile_bins(window, rects, order);
    ASSERT_EQ(bins.n_tiles(), 70u);
    for (std::size_t t = 0; t < bins.n_tiles(); ++t) {
        const int x = static_cast<int>(t % 10) * kTileSize,
                  y = static_cast<int>(t / 10) * kTileSize;
        std::vector<std::uint32_t> touching;
        for (const std::uint32_t i : order) {
            const ScreenRect& r = rects[i];
            if (r.x0 < x + kTileSize && r.x1 > x && r.y0 < y + kTileSize && r.y1 > y)
                touching.push_back(i);
        }
        ASSERT_EQ(std::vector<std::uint32_t>(bins.of(t).begin(), bins.of(t).end()), touching) << t;
    }
}

}  // namespace
}  // namespace slim
